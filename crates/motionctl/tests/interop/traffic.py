"""Logs of DYN CAN for the checks of the files in `interop`: simulated runs, a bench, and frames at random."""

import os
import pathlib
import random
import signal
import subprocess
import sys
import time

PATIENCE_S = 20

# Every kind of fault that changes the traffic of a run; what a master latches ends it.
FAULTS = """
[[drop_replies]]
at_s = 0.2
drive = 1
count = 2
[[delay_reply]]
at_s = 0.3
drive = 2
by_s = 0.014
[[repeat_set_point]]
at_s = 0.4
drive = 2
count = 3
[[corrupt]]
at_s = 0.5
frames = 3
[[silence]]
at_s = 0.6
drive = 3
for_s = 0.012
[[power_cycle]]
at_s = 0.9
drive = 4
off_s = 0.1
[[alarm]]
at_s = 0.9
drive = 2
alarm = "command-refused"
repeat_s = 0.02
"""

# Requests to a drive on the bench, by the function codes of the CAN specification, section 6; most are answered.
BENCH_REQUESTS = [
    (0x06, b""), (0x08, b""), (0x09, b""), (0x13, b""), (0x14, b""), (0x15, b""), (0x1A, b""), (0x1F, b""), (0x1F, b""),
    (0x0E, b"\x1B"), (0x0E, b"\x1E"), (0x1E, bytes([1, 2, 3, 254])), (0x10, bytes([20, 0, 30, 0])), (0x13, b""),
    (0x11, bytes([0, 40])), (0x14, b""), (0x12, bytes([30, 0x10, 0x00, 0, 0])), (0x15, b""), (0x19, b"\x00"), (0x09, b""),
    (0x03, bytes([0x12, 0x34])), (0x0E, b"\x1B"), (0x09, b""), (0x01, bytes([0xF0])), (0x0A, bytes([0x00, 0x80])), (0x1A, b""),
    (0x1C, bytes([0x88])), (0x17, bytes([0x01, 0x00])), (0x18, b"\xEE"), (0x19, b"\xFF"), (0x1B, b"\xFE"), (0x09, b""),
    (0x0B, bytes([0x02, 0x00])), (0x0C, bytes([0x7F])), (0x0D, bytes([51])), (0x0D, bytes([2])), (0x07, b"\x00"), (0x08, b""),
]

# Read_Param_Group3 replies: 1.6A in both byte orders, 1.2A in both, and one of 1.2A that fits both.
GROUP3_REPLIES = [
    (0x15, bytes([20, 0, 0x00, 0x10, 0xC4, 0x09])), (0x15, bytes([0, 20, 0x10, 0x00, 0x09, 0xC4])),
    (0x15, bytes([20, 0x10, 0x00, 0x09, 0xC4])), (0x15, bytes([20, 0x00, 0x10, 0xC4, 0x09])), (0x15, bytes([20, 0x10, 0x08, 0, 0])),
]


def line(time_ns, can_id, data):
    return f"({time_ns // 10**9}.{time_ns % 10**9 // 1000:06}) can0 {can_id:03X}#{bytes(data).hex().upper()}\n"


def simulated(motionctl, path, *options):
    """The traffic of a run, which a fault may end."""
    command = [motionctl, "sim", "--json", "--candump", path, *options]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode > 1:
        sys.exit(f"{command}: exit status {run.returncode}: {run.stderr}")
    return path


def bench(motionctl, path, folder, revision):
    """What a bench with three drives, one of them in alarm, answers to every kind of request."""
    import can

    adapter = str(folder / f"adapter-{revision}")
    command = [motionctl, "bench", "--drives", "1,2,9", "--alarm", "9", "--revision", revision, "--slcan", adapter]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        end = time.monotonic() + PATIENCE_S
        while not os.path.exists(adapter):
            if time.monotonic() > end or process.poll() is not None:
                sys.exit(f"the bench did not make {adapter} within {PATIENCE_S} s")
            time.sleep(0.02)
        with can.Bus(interface="slcan", channel=adapter, bitrate=1_000_000, sleep_after_open=0.1) as bus, open(path, "w") as log:
            for drive in (1, 2, 9):
                for function, data in BENCH_REQUESTS:
                    converse(can, bus, log, drive << 5 | function, data)
            converse(can, bus, log, 0x018, b"\xFF")
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(timeout=PATIENCE_S)
    return path


def converse(can, bus, log, can_id, data):
    """A request and what comes within a while, with times of this program."""
    log.write(line(time.time_ns(), can_id, data))
    bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False))
    while (reply := bus.recv(timeout=0.03)) is not None:
        log.write(line(time.time_ns(), reply.arbitration_id, reply.data))


def at_random(path, seed, frames):
    """Frames of every function, length and age: sensible ones, ones at the edges, and nonsense."""
    chance = random.Random(seed)
    edges = [0x00, 0x01, 0x1B, 0x1E, 0x7F, 0x80, 0xAB, 0xEE, 0xFE, 0xFF, 0x10, 0x18, 0x3F, 0x40]
    now_ns, recent = 1_700_000_000 * 10**9, []
    with open(path, "w") as log:
        for _ in range(frames):
            now_ns += chance.choice([40_000, 150_000, 199_000, 200_000, 201_000, 700_000, 9_999_000, 10_000_000, 10_001_000, 30_000_000])
            if recent and chance.random() < 0.4:
                can_id, data = chance.choice(recent[-4:])
                if chance.random() < 0.5:
                    data = random_data(chance, edges)
            elif chance.random() < 0.5:
                function, data = chance.choice(BENCH_REQUESTS + GROUP3_REPLIES)
                can_id = chance.choice([1, 2]) << 5 | function
            else:
                can_id = chance.choice([0, 1, 2, 9, 63]) << 5 | chance.randrange(32)
                data = random_data(chance, edges)
            recent.append((can_id, data))
            log.write(line(now_ns, can_id, data))
            if chance.random() < 0.01:
                log.write(f"({now_ns // 10**9}.{now_ns % 10**9 // 1000:06}) can0 {chance.choice(['0000003E#01', '03E#R', '03E#R4'])}\n")
    return path


def random_data(chance, edges):
    count = chance.choice([0, 0, 1, 1, 1, 2, 2, 3, 4, 4, 5, 5, 6, 7, 8])
    return bytes(chance.choice(edges) if chance.random() < 0.7 else chance.randrange(256) for _ in range(count))


def every_kind(motionctl, folder):
    """The logs, each with the options of `decode` that it is to be read with."""
    folder = pathlib.Path(folder)
    faults = folder / "faults.toml"
    faults.write_text(FAULTS)
    logs = []
    for revision in ("1.6A", "1.2A"):
        simulated_log = simulated(motionctl, folder / f"sim-{revision}.log", "--revision", revision)
        with_faults = simulated(motionctl, folder / f"faults-{revision}.log", "--revision", revision, "--faults", faults)
        of_bench = bench(motionctl, folder / f"bench-{revision}.log", folder, revision)
        logs += [(simulated_log, None), (with_faults, None), (of_bench, None), (of_bench, revision)]
    seed = int(os.environ.get("SEED", "1"))
    for number, revision in enumerate([None, "1.2A", "1.6A"]):
        logs.append((at_random(folder / f"random-{seed + number}.log", seed + number, 20_000), revision))
    return logs
