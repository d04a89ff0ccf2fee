"""The tool for Windows under Wine, beside the tool for this system: the same outputs, and what is different on Windows.

Usage: windows.py MOTIONCTL MOTIONCTL.EXE

Both read the same files and run in folders of their own. What they print and write must be equal to the last byte. Then a motion on the bench of
this system is driven by the program of Windows, and the other way around. Nothing here shows how well a real Windows keeps time, and no
adapter is real.
"""

import contextlib
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

ROOT = os.getcwd()
PATIENCE_S = 120
# How often a motion is tried: it runs in real time.
ATTEMPTS = 4
COMPILER = "x86_64-w64-mingw32-gcc"

# Wine 8 lacks one library that the standard library of Rust takes random numbers from.
RANDOM = """
#include <windows.h>
#include <ntsecapi.h>
__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE data, SIZE_T length) { return RtlGenRandom(data, (ULONG)length); }
"""

PLAN = "time_s,a_deg,b_deg\n0,0,0\n0.5,90,-45\n1,180,-90\n"
LONG = "time_s,a_deg\n0,0\n60,7200\n"
BAD = "time_s,a_deg\n0,0\n0.5,x\n"

# Commands, with the exit status and the files that they write.
SAME = [
    (["--version"], 0, []),
    (["sim", "--help"], 0, []),
    (["plan", "--axes", "4"], 0, []),
    (["plan", "--axes", "8", "--json"], 0, []),
    (["plan", "--axes", "30"], 1, []),
    (["sim"], 0, []),
    (["sim", "--trajectory", "plan.csv", "--axes", "2", "--candump", "sim.log", "--csv", "sim.csv"], 0, ["sim.log", "sim.csv"]),
    (["sim", "--trajectory", "windows.csv", "--axes", "2", "--json"], 0, []),
    (["sim", "--trajectory", "bad.csv", "--axes", "1"], 2, []),
    (["sim", "--drives", "zlac", "--json"], 0, []),
    (["check", "--trajectory", "plan.csv", "--axes", "2"], 0, []),
    (["decode", "sim.log"], 0, []),
    (["decode", "sim.log", "--json"], 0, []),
    (["decode", "windows.log", "--statistics-only"], 0, []),
]

checked = 0


def expect(what, expected, actual):
    """Ends the test when two values differ."""
    global checked
    checked += 1
    if expected != actual:
        sys.exit(f"{what}: expected {expected!r:.2000}, got {actual!r:.2000}")


def expect_in(what, expected, text):
    """Ends the test when a text does not hold what it should."""
    global checked
    checked += 1
    if expected not in text:
        sys.exit(f"{what}: expected {expected!r} in {text!r:.2000}")


class Windows:
    """Wine with the program and the libraries beside it."""

    def __init__(self, folder, program):
        self.folder = os.path.join(folder, "windows")
        os.mkdir(self.folder)
        self.program = os.path.join(self.folder, "motionctl.exe")
        shutil.copy(program, self.program)
        self.environment = dict(os.environ, WINEPREFIX=os.path.join(folder, "wine"), WINEARCH="win64", WINEDEBUG="-all",
                                WINEDLLOVERRIDES="mscoree,mshtml=")
        self.compile("bcryptprimitives.dll", RANDOM, "-shared", "-ladvapi32")
        subprocess.run(["wineboot", "-i"] if shutil.which("wineboot") else ["wine", "wineboot", "-i"],
                       env=self.environment, check=True, timeout=PATIENCE_S, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def compile(self, name, source, *options):
        """A program or a library for Windows, beside the tool."""
        path = os.path.join(self.folder, f"{name}.c")
        with open(path, "w", encoding="ascii") as file:
            file.write(source)
        place = os.path.join(self.folder, name)
        subprocess.run([COMPILER, "-O1", "-o", place, path, *options], check=True, timeout=PATIENCE_S)
        return place

    def start(self, words):
        return subprocess.Popen(["wine", self.program, *words], cwd=self.folder, env=self.environment,
                                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def run(self, words):
        child = self.start(words)
        output, errors = child.communicate(timeout=PATIENCE_S)
        return child.returncode, output, errors

    def stop(self):
        subprocess.run(["wineserver", "-k"] if shutil.which("wineserver") else ["wine", "wineboot", "-k"],
                       env=self.environment, check=False, timeout=PATIENCE_S, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


class Here:
    """This system."""

    def __init__(self, folder, program):
        self.folder = os.path.join(folder, "here")
        os.mkdir(self.folder)
        self.program = os.path.abspath(program)

    def start(self, words):
        return subprocess.Popen([self.program, *words], cwd=self.folder, stdin=subprocess.DEVNULL,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def run(self, words):
        child = self.start(words)
        output, errors = child.communicate(timeout=PATIENCE_S)
        return child.returncode, output, errors


def read(system, name):
    with open(os.path.join(system.folder, name), "rb") as file:
        return file.read()


def same_outputs(here, windows):
    """Every output and file is equal to the last byte; ends of lines are those of a file, whatever the system is."""
    for words, status, files in SAME:
        (code, output, errors), other = [system.run(words) for system in (here, windows)]
        line = " ".join(words)
        # A program is called by its file's name in its help.
        expect(f"{line}: exit statuses", (status, status), (code, other[0]))
        expect(f"{line}: errors", errors, other[2].replace(b"motionctl.exe", b"motionctl"))
        expect(f"{line}: output", output, other[1].replace(b"motionctl.exe", b"motionctl"))
        for name in files:
            expect(f"{line}: {name}", read(here, name), read(windows, name))
            expect(f"{line}: {name} has something in it", True, len(read(here, name)) > 1000)
        if "sim.log" in files:
            for system in (here, windows):
                with open(os.path.join(system.folder, "windows.log"), "wb") as file:
                    file.write(read(system, "sim.log").replace(b"\n", b"\r\n"))


def refusals(windows):
    """What Windows does not have is refused with what to use in its place."""
    for words, status, text in [
        (["scan", "--slcan", "COM77"], 3, "there is no port COM77: is the adapter plugged in? This computer has "),
        (["scan", "--serial", "COM77"], 3, "there is no port COM77"),
        (["scan", "--can", "can0"], 3, "--can pcan:PCAN_USBBUS1 with a PCAN-USB on Windows"),
        (["scan", "--can", "pcan:PCAN_USBBUS1"], 3, "there is no PCANBasic.dll"),
        (["bench", "--slcan", r"C:\adapter"], 2, "Windows has no pseudo-terminals: use a port in place of a path"),
    ]:
        code, _, errors = windows.run(words)
        expect(f"{words}: exit status", status, code)
        expect_in(f"{words}: errors", text, errors.decode())


def pcan(windows):
    """PEAK's library, as the tests of its crate have it."""
    with open(os.path.join(ROOT, "crates/pcan-basic/tests/fake/pcan_basic.c"), encoding="ascii") as file:
        windows.compile("PCANBasic.dll", file.read(), "-shared")
    for channel, command, text in [(2, "scan", "there is no adapter at"), (3, "scan", "in use by another program"),
                                   (4, "scan", "at 500 kbit/s: another program"), (5, "scan", "the adapter is bus-off"),
                                   (10, "decode", "cannot listen without acknowledging")]:
        code, _, errors = windows.run([command, "--can", f"pcan:PCAN_USBBUS{channel}"])
        expect(f"channel {channel}: exit status", 3, code)
        expect_in(f"channel {channel}: errors", text, errors.decode())
    # The node there answers with frames that no drive sends.
    code, output, errors = windows.run(["scan", "--json", "--can", "pcan:PCAN_USBBUS1"])
    expect(f"scan of channel 1: {errors}", [], json.loads(output)["drives"])
    expect("scan of channel 1: exit status", 1, code)


def port_of(child):
    """The port that a bench has chosen."""
    line = child.stderr.readline().decode()
    words = [word.rstrip(";") for word in line.split() if word.startswith("tcp:")]
    if not words:
        sys.exit(f"the bench did not start: {line}")
    return words[0]


@contextlib.contextmanager
def bench(system, drives):
    """A bench behind a port; its report comes in a list."""
    child = system.start(["bench", "--drives", drives, "--slcan", "tcp:0", "--json"])
    report = []
    try:
        yield port_of(child), report
        child.send_signal(signal.SIGINT)
        output, _ = child.communicate(timeout=PATIENCE_S)
        expect("exit status of the bench", 0, child.returncode)
        report.append(json.loads(output))
    finally:
        child.kill()


def found(answer):
    code, output, errors = answer
    expect(f"exit status of scan ({errors})", 0, code)
    return [drive["drive"] for drive in json.loads(output)["drives"]]


def scan_both_ways(here, windows):
    for near, far in [(here, windows), (windows, here)]:
        with bench(far, "1,9") as (port, _):
            expect(f"drives behind {port}", [1, 9], found(near.run(["scan", "--json", "--slcan", port])))


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def wait_for_cycle(child, port, cycle):
    """Waits until a motion has come so far; whether it did not end before."""
    end = time.monotonic() + PATIENCE_S
    passed = 0
    while passed < cycle:
        if child.poll() is not None:
            return False
        if time.monotonic() > end:
            sys.exit(f"the motion did not come to cycle {cycle}: {passed} passed")
        time.sleep(0.2)
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S) as control:
            control.sendall(b"status\n")
            answer = control.recv(256).decode()
            passed = int(answer.partition("cycle=")[2].partition(" ")[0] or 0)
    return True


def interrupted_motion(here, windows):
    """A motion that is told to end with Ctrl-C: exit status, outputs, and the report of the bench."""
    with bench(here, "1") as (port, report):
        expect("disable", 0, windows.run(["disable", "--slcan", port, "--drives", "1"])[0])
        control = free_port()
        # Slow cycles: nothing here is about the pace.
        child = windows.start(["run", "--json", "--yes", "--max-turns", "200", "--cycle-us", "10000",
                               "--trajectory", "long.csv", "--slcan", port, "--control", f"tcp:{control}"])
        if wait_for_cycle(child, control, 100):
            child.send_signal(signal.SIGINT)
        output, errors = child.communicate(timeout=PATIENCE_S)
    return child.returncode, output, errors, report[0]


def ending(here, windows):
    """The drive is slowed down and disabled. Wine delivers SIGINT as Ctrl-C, and has no way to deliver Ctrl-Break here."""
    for _ in range(ATTEMPTS):
        code, output, errors, report = interrupted_motion(here, windows)
        if b"this computer or its adapter is too slow" not in errors:
            break
        print("    once more: a motion needs a computer that is not busy with other things")
    expect(f"exit status ({errors} {output})", 130, code)
    summary, drive = json.loads(output), report["drives"][0]
    expect("outcome", "stopped by the user", summary["outcome"])
    expect("disabled", [1], summary["disabled"])
    expect("the drive is off", False, drive["enabled"])
    expect("it had moved", True, drive["received_counts"] > 0)
    expect("every step", summary["axes"][0]["sent_counts"], drive["received_counts"])


def main():
    motionctl, program = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        here, windows = Here(folder, motionctl), Windows(folder, program)
        try:
            for system in (here, windows):
                shutil.copytree(os.path.join(ROOT, "examples"), os.path.join(system.folder, "examples"))
                for name, text in [("plan.csv", PLAN), ("windows.csv", PLAN.replace("\n", "\r\n")), ("bad.csv", BAD), ("long.csv", LONG)]:
                    with open(os.path.join(system.folder, name), "w", encoding="ascii", newline="") as file:
                        file.write(text)
            ending(here, windows)
            scan_both_ways(here, windows)
            refusals(windows)
            pcan(windows)
            same_outputs(here, windows)
        finally:
            windows.stop()
    print(f"the program of Windows under Wine: {checked} checks")


main()
