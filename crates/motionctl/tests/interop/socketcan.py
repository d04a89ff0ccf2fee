"""SocketCAN for real: a kernel with CAN, can-utils, and the bench as the adapter behind a network interface.

Usage: socketcan.py MOTIONCTL

Most build machines have no CAN in their kernel. User-mode Linux (Debian: user-mode-linux) is a kernel that runs as a program
and has it; this file is also the first process of that kernel. In there, slcand of can-utils makes the network interface can0
of the bench's terminal, through the kernel's own driver for Lawicel adapters.

The kernel reads the files of its host, but its own /dev, /proc, /run and /sys hide the host's, and a path with a space is two
words of its command line. Both programs are therefore copied to a folder that it finds, wherever the checkout is.
"""

import contextlib
import ctypes
import glob
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback

PATIENCE_S = 60
BOOT_AND_CHECKS_S = 400
STARTED = "a kernel with CAN:"
PASSED = "all checks passed:"

# Where the host's files can be read inside: nothing is mounted over it.
SEEN_INSIDE = "/var/tmp"

MODULES = ["net/can/can", "net/can/can-raw", "drivers/net/can/dev/can-dev", "drivers/net/can/vcan", "drivers/net/can/slcan/slcan"]
FINIT_MODULE = 313  # x86-64, the only machine that user-mode Linux has
POWER_OFF = 0x4321FEDC

SHORT = "time_s,a,b\n0,0,0\n0.5,180,-90\n1,360,-180\n"
LONG = "time_s,a,b\n0,0,0\n60,36000,-36000\n"
# The kernel below shares one processor with drives, adapter and decoder.
SLOW = ["--cycle-us", "5000"]

checked = 0


def outside(motionctl):
    """Starts the kernel and reads what its first process says."""
    missing = [tool for tool in ["linux.uml", "slcand", "candump", "cansend", "ip"] if not shutil.which(tool)]
    if missing:
        print(f"SKIPPED: there is no {', '.join(missing)} (Debian: user-mode-linux, can-utils, iproute2), so no CAN interface was tried")
        return
    with tempfile.TemporaryDirectory(prefix="socketcan-", dir=SEEN_INSIDE) as folder:
        report(start_kernel(shutil.copy(__file__, folder), shutil.copy(motionctl, folder)))


def start_kernel(script, motionctl):
    command = ["linux.uml", "root=/dev/root", "rootfstype=hostfs", "rootflags=/", "ro", "mem=256M", "con=null", "con0=null,fd:1",
               "quiet", f"init={os.path.realpath(sys.executable)}", "--", script, motionctl]
    return subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace",
                          timeout=BOOT_AND_CHECKS_S, check=False)


def report(kernel):
    said = kernel.stdout.replace("\r", "")
    if STARTED not in said:
        print(f"SKIPPED: user-mode Linux does not start here, so no CAN interface was tried: {said[-300:]}{kernel.stderr[-300:]}")
        return
    print(said[said.index(STARTED):].strip())
    if PASSED not in said:
        sys.exit(1)


def expect(what, expected, actual):
    """Ends the test when two values differ."""
    global checked
    checked += 1
    if expected != actual:
        raise AssertionError(f"{what}: expected {expected!r}, got {actual!r}")


def contains(what, text, wanted):
    expect(f"{what}: {wanted!r} in the end of {text[-500:]!r}", True, wanted in text)


def mount():
    """The kernel's own file systems; the rest of the host's files can be read, not written."""
    for kind, place in [("proc", "/proc"), ("sysfs", "/sys"), ("devtmpfs", "/dev"), ("tmpfs", "/run")]:
        if not os.path.ismount(place):
            subprocess.run(["mount", "-t", kind, kind, place], check=True)
    os.makedirs("/dev/pts", exist_ok=True)
    subprocess.run(["mount", "-t", "devpts", "devpts", "/dev/pts"], check=True)


def load_modules():
    libc = ctypes.CDLL(None, use_errno=True)
    for module in MODULES:
        [path] = glob.glob(f"/usr/lib/uml/modules/{os.uname().release}/kernel/{module}.ko*")
        with open(path, "rb") as file:
            if libc.syscall(FINIT_MODULE, file.fileno(), b"", 0) != 0:
                raise OSError(ctypes.get_errno(), f"module {path}")


def ip(*words):
    subprocess.run(["ip", "link", *words], check=True)


class Tool:
    """motionctl."""

    def __init__(self, path):
        self.path = path

    def run(self, *arguments):
        done = subprocess.run([self.path, *arguments], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              timeout=2 * PATIENCE_S, check=False)
        return done.returncode, done.stdout, done.stderr

    def json(self, *arguments):
        status, text, errors = self.run(*arguments, "--json")
        expect(f"status of {arguments}: {text}{errors}", 0, status)
        return json.loads(text)

    def start(self, *arguments):
        return subprocess.Popen([self.path, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)


def wait_for(what, is_so):
    end = time.monotonic() + PATIENCE_S
    while not is_so():
        if time.monotonic() > end:
            raise AssertionError(f"still waiting for {what}")
        time.sleep(0.02)


def interfaces_that_cannot_be_used(tool):
    ip("add", "dev", "vcan0", "type", "vcan")
    for interface, message in [("vcan0", "vcan0 is down"), ("lo", "there is no CAN interface lo"),
                               ("nocan", "there is no CAN interface nocan")]:
        status, _, errors = tool.run("scan", "--can", interface)
        expect(f"status with {interface}", 3, status)
        contains(interface, errors, message)
    ip("set", "vcan0", "up")
    status, _, errors = tool.run("read", "--can", "vcan0", "--drive", "1")
    expect("status on an empty bus", 1, status)
    contains("an empty bus", errors, "drive 1 does not answer")


@contextlib.contextmanager
def bench(tool):
    """A bench with two drives behind the network interface can0."""
    process = tool.start("bench", "--drives", "1,3", "--slcan", "/run/adapter", "--json")
    wait_for("the adapter", lambda: os.path.exists("/run/adapter"))
    subprocess.run(["slcand", "-o", "-c", "-s8", os.readlink("/run/adapter"), "can0"], check=True)
    wait_for("the interface", lambda: os.path.exists("/sys/class/net/can0"))
    ip("set", "can0", "up")
    try:
        yield process
    finally:
        process.kill()


def standard_tools():
    """can-utils ask a drive for its status."""
    dump = subprocess.Popen(["candump", "-L", "-n", "2", "can0,029:7FF"], stdout=subprocess.PIPE, text=True)
    time.sleep(0.5)
    subprocess.run(["cansend", "can0", "029#"], check=True)
    lines, _ = dump.communicate(timeout=PATIENCE_S)
    expect("request and reply in candump", ["029#", "029#00"], re.findall(r"029#\d*", lines))


def commissioning(tool):
    drives = [{"drive": drive, "protocol": "CAN 1.6A"} for drive in [1, 3]]
    expect("scan", {"drives": drives}, tool.json("scan", "--can", "can0"))
    tool.json("disable", "--can", "can0", "--drives", "3")
    tool.json("write", "--can", "can0", "--drive", "3", "max-speed=40", "--yes")
    readings = tool.json("read", "--can", "can0", "--drive", "3")["parameters"]
    expect("max speed", [40], [reading["value"] for reading in readings if reading["parameter"] == "max-speed"])


def motion_under_a_decoder(tool):
    """A whole motion, while decode listens to the same interface."""
    with open("/run/short.csv", "w", encoding="utf-8") as file:
        file.write(SHORT)
    listener = tool.start("decode", "--can", "can0")
    summary = tool.json("run", "--can", "can0", "--trajectory", "/run/short.csv", "--drives", "1,3", *SLOW, "--yes")
    expect("sums sent", [16384, -8192], [axis["sent_counts"] for axis in summary["axes"]])
    expect("positions read", [16384, -8192], [axis["read_counts"] for axis in summary["axes"]])
    listener.send_signal(signal.SIGINT)
    words, errors = listener.communicate(timeout=PATIENCE_S)
    expect(f"status of decode: {errors}", 0, listener.returncode)
    contains("decode", words, "Go_Relative_Pos_PD: step by")
    for trouble in [" 0 did not decode,", " 0 error frames,"]:
        contains("decode", words, trouble)


def start_long_motion(tool):
    run = tool.start("run", "--can", "can0", "--trajectory", "/run/long.csv", "--drives", "1,3", "--max-turns", "1000",
                     *SLOW, "--yes")
    words = ""
    while "the motion starts" not in words:
        line = run.stderr.readline()
        contains("run", line, "\n")
        words += line
    return run


def interface_down_in_mid_run(tool):
    with open("/run/long.csv", "w", encoding="utf-8") as file:
        file.write(LONG)
    run = start_long_motion(tool)
    ip("set", "can0", "down")
    text, errors = run.communicate(timeout=PATIENCE_S)
    expect("status when the interface goes down", 3, run.returncode)
    contains("run", text, "the network interface is down")
    contains("run", errors, "may still be ENABLED")
    ip("set", "can0", "up")
    ended = tool.json("disable", "--can", "can0", "--drives", "1,3")
    expect("disabled afterwards", {"disabled": [1, 3], "unconfirmed": [], "left_enabled": []}, ended)


def adapter_pulled_in_mid_run(tool, process):
    run = start_long_motion(tool)
    process.kill()
    text, _ = run.communicate(timeout=PATIENCE_S)
    expect("status when the adapter is pulled", 3, run.returncode)
    contains("run", text, "the link failed")


def inside(motionctl):
    """The first process of the kernel."""
    os.environ["PATH"] = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"
    mount()
    load_modules()
    print(STARTED, os.uname().release, flush=True)
    tool = Tool(motionctl)
    interfaces_that_cannot_be_used(tool)
    with bench(tool) as process:
        standard_tools()
        commissioning(tool)
        motion_under_a_decoder(tool)
        interface_down_in_mid_run(tool)
        adapter_pulled_in_mid_run(tool, process)
    print(PASSED, checked, flush=True)


def main():
    if os.getpid() != 1:
        outside(sys.argv[1])
        return
    try:
        inside(sys.argv[1])
    except BaseException:
        traceback.print_exc(file=sys.stdout)
    finally:
        sys.stdout.flush()
        ctypes.CDLL(None).reboot(POWER_OFF)


main()
