"""The bench's CAN adapter, driven by python-can's slcan client, and a whole motion of `motionctl run` through it.

Usage: python_can_bench.py MOTIONCTL README

Identifiers and bytes are written from the drives' CAN specification and share nothing with the product. The script of the
README is executed as it stands there.
"""

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time

import can

PATIENCE_S = 20
QUIET_S = 0.5

# Function codes of the CAN specification, section 6.
READ_STATUS, GENERAL_READ, READ_GROUP3 = 0x09, 0x0E, 0x15
SET_POINT, DRIVE_ERROR = 0x1C, 0x1D
POSITION = 0x1B
ALARM_FRAME = 0xEE
LOST_PHASE = 1
# General_Read of the position, as the README shows it.
SCRIPT = re.compile(r"```python\n(.*?)```", re.DOTALL)

checked = 0


def expect(what, expected, actual):
    """Ends the test when two values differ."""
    global checked
    checked += 1
    if expected != actual:
        sys.exit(f"{what}: expected {expected!r}, got {actual!r}")


@contextlib.contextmanager
def bench(motionctl, adapter, drives, report):
    """A bench with its adapter; its report is filled in at the end."""
    process = subprocess.Popen([motionctl, "bench", "--drives", drives, "--slcan", adapter, "--json"],
                               stdout=subprocess.PIPE)
    try:
        end = time.monotonic() + PATIENCE_S
        while not os.path.exists(adapter):
            if time.monotonic() > end:
                sys.exit(f"the bench did not make {adapter} within {PATIENCE_S} s")
            time.sleep(0.02)
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate(timeout=PATIENCE_S)
    expect("exit status of the bench", 0, process.returncode)
    report.update(json.loads(output))


def open_bus(adapter, **options):
    return can.Bus(interface="slcan", channel=adapter, sleep_after_open=0.1, **options)


class Host:
    """A host on the bus."""

    def __init__(self, bus):
        self.bus = bus

    def send(self, drive, function, *data):
        self.bus.send(can.Message(arbitration_id=drive << 5 | function, data=data, is_extended_id=False))

    def hear(self, drive, function, patience_s=PATIENCE_S):
        """The data of the next frame of a drive's function; None when none comes."""
        end = time.monotonic() + patience_s
        while (left := end - time.monotonic()) > 0:
            message = self.bus.recv(timeout=left)
            if message and message.arbitration_id == drive << 5 | function and not message.is_extended_id:
                return bytes(message.data)
        return None

    def ask(self, drive, function, *data, patience_s=PATIENCE_S):
        self.send(drive, function, *data)
        return self.hear(drive, function, patience_s)

    def position(self, drive):
        return int.from_bytes(self.ask(drive, GENERAL_READ, POSITION), "big", signed=True)

    def scan(self, ids):
        return [drive for drive in ids if self.ask(drive, READ_GROUP3, patience_s=QUIET_S)]


def adapter_commands(bus):
    expect("version", (10, 13), bus.get_version(PATIENCE_S))
    expect("serial number", "VIRT", bus.get_serial_number(PATIENCE_S))


def scan(host):
    expect("drives that answer", [1, 2, 9], host.scan([1, 2, 3, 9, 10]))
    # 1.6A, #21: six bytes; 1.2A sends five.
    expect("length of parameter group 3", 6, len(host.ask(1, READ_GROUP3)))


def move(host):
    expect("status before", b"\x00", host.ask(1, READ_STATUS))
    for _ in range(50):
        host.send(1, SET_POINT, 0, 40)
        host.send(2, SET_POINT, 0xD8)
        # One cycle; a burst would fill the adapter's queue.
        time.sleep(0.001)
    end = time.monotonic() + PATIENCE_S
    while (host.position(1), host.position(2)) != (2000, -2000):
        if time.monotonic() > end:
            sys.exit(f"drives 1 and 2 stand at {host.position(1)} and {host.position(2)} instead of 2000 and -2000")


def frames_of_other_kinds(host):
    """The drives answer data frames with 11 bits only."""
    host.bus.send(can.Message(arbitration_id=1 << 5 | READ_STATUS, is_remote_frame=True, is_extended_id=False))
    host.bus.send(can.Message(arbitration_id=1 << 5 | READ_STATUS, is_extended_id=True))
    expect("answer to a remote and an extended frame", None, host.hear(1, READ_STATUS, QUIET_S))


def alarm(host):
    """Steps that no motor can follow: the drive reports the lost phase by itself, and then in its status."""
    for _ in range(4):
        host.send(9, SET_POINT, 0x3E, 0x80)
    expect("alarm frame", bytes([ALARM_FRAME]), host.hear(9, DRIVE_ERROR))
    status = host.ask(9, READ_STATUS)[0]
    expect("alarm in the status", LOST_PHASE, status >> 2 & 7)


def other_ways_to_open(adapter):
    with open_bus(adapter, bitrate=1_000_000, listen_only=True) as bus:
        expect("answer to a listener", None, Host(bus).ask(1, READ_STATUS, patience_s=QUIET_S))
    with open_bus(adapter, bitrate=500_000) as bus:
        expect("answer at another bit rate", None, Host(bus).ask(1, READ_STATUS, patience_s=QUIET_S))


def script_of_the_readme(readme, adapter):
    with open(readme, encoding="utf-8") as file:
        scripts = SCRIPT.findall(file.read())
    expect("python scripts in the README", 1, len(scripts))
    expect("at most ten lines", True, len(scripts[0].strip().splitlines()) <= 10)
    script = scripts[0].replace("/tmp/can-adapter", adapter)
    output = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    expect("errors of the README's script", "", output.stderr)
    expect("output of the README's script", "position in counts: 2000\n", output.stdout)


def over_a_socket(motionctl):
    """The same drives where there are no pseudo-terminals: python-can opens the port of the bench as pyserial's socket://."""
    process = subprocess.Popen([motionctl, "bench", "--drives", "1,2,9", "--slcan", "tcp:0", "--json"],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        port = re.search(r"tcp:(127\.0\.0\.1:\d+)", process.stderr.readline())[1]
        with open_bus(f"socket://{port}", bitrate=1_000_000) as bus:
            adapter_commands(bus)
            scan(Host(bus))
            with contextlib.suppress(can.CanError, OSError), open_bus(f"socket://{port}", bitrate=1_000_000) as second:
                expect("answer to a second host", None, Host(second).ask(1, READ_STATUS, patience_s=QUIET_S))
            move(Host(bus))
        # Whoever has gone may come back.
        with open_bus(f"socket://{port}", bitrate=1_000_000) as bus:
            alarm(Host(bus))
    finally:
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate(timeout=PATIENCE_S)
    expect("exit status of the bench", 0, process.returncode)
    expect("books over a socket", [2000, -2000],
           [drive["received_counts"] for drive in json.loads(output)["drives"][:2]])
    expect("the second host was refused", True, "the adapter has one host at a time" in errors)


def whole_motion(motionctl, adapter, report):
    """The pick-and-place on four drives; both sides keep their own books."""
    with bench(motionctl, adapter, "1-4", report):
        run = subprocess.run([motionctl, "run", "--slcan", adapter, "--yes", "--json"],
                             capture_output=True, text=True, timeout=5 * PATIENCE_S, check=False)
    if run.returncode != 0:
        sys.exit(f"motionctl run ended with {run.returncode}: {run.stdout}{run.stderr}")
    summary = json.loads(run.stdout)
    expect("motion completed", True, summary["completed"])
    sent = [axis["sent_counts"] for axis in summary["axes"]]
    expect("sent and planned", [axis["target_counts"] for axis in summary["axes"]], sent)
    expect("sent and received", [drive["received_counts"] for drive in report["drives"]], sent)
    pace = summary["pace"]
    # Six seconds of motion at 1 kHz: every cycle is begun, or told as missed.
    expect("cycles accounted for", True, pace["cycles"] + pace["merged"] >= 6000)
    return pace


def main():
    motionctl, readme = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        adapter, report = os.path.join(folder, "adapter"), {}
        with bench(motionctl, adapter, "1,2,9", report):
            with open_bus(adapter, bitrate=1_000_000) as bus:
                host = Host(bus)
                adapter_commands(bus)
                scan(host)
                move(host)
                frames_of_other_kinds(host)
            script_of_the_readme(readme, adapter)
            other_ways_to_open(adapter)
            with open_bus(adapter, bitrate=1_000_000) as bus:
                alarm(Host(bus))
        expect("books of drives 1 and 2", [2000, -2000], [drive["received_counts"] for drive in report["drives"][:2]])
        over_a_socket(motionctl)
        pace = whole_motion(motionctl, adapter, report)
    print(f"python-can {can.__version__}: {checked} checks on the bench passed; "
          f"the motion had {pace['late']} late and {pace['merged']} merged of {pace['cycles']} cycles")


main()
