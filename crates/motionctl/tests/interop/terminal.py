"""The live views in a terminal of 80 columns and 24 lines, drawn by tmux: every axis and every key is on the screen, and the keys work.

Usage: terminal.py MOTIONCTL

What is on the screen is what tmux shows of it, which shares nothing with the product.
"""

import atexit
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

PATIENCE_S = 60
COLUMNS, LINES = 80, 24
NAMES = [f"joint{number}" for number in range(1, 15)]

checked = 0


class Terminal:
    """A program in a terminal of a server of its own."""

    def __init__(self, folder, words):
        self.server = os.path.join(folder, "tmux.socket")
        self.status = os.path.join(folder, "status")
        if os.path.exists(self.status):
            os.remove(self.status)
        quoted = " ".join("'" + word.replace("'", "'\\''") + "'" for word in words)
        # The shell stays, so that the screen does too; Ctrl-C is for the program.
        script = f"trap : INT; {quoted}; echo $? > {self.status}.new; mv {self.status}.new {self.status}; sleep 60"
        self.tmux("-f", "/dev/null", "new-session", "-d", "-x", str(COLUMNS), "-y", str(LINES), "sh", "-c", script)
        # Its own line of status would take one of the 24.
        self.tmux("set-option", "-g", "status", "off")
        self.tmux("resize-window", "-x", str(COLUMNS), "-y", str(LINES))

    def tmux(self, *words):
        return subprocess.run(["tmux", "-S", self.server, *words], check=True, capture_output=True, text=True).stdout

    def screen(self):
        return self.tmux("capture-pane", "-p")

    def press(self, *keys):
        self.tmux("send-keys", *keys)

    def wait_for(self, what, is_so):
        """The first screen that is so."""
        end = time.monotonic() + PATIENCE_S
        while True:
            screen = self.screen()
            if is_so(screen):
                return screen
            if time.monotonic() > end or os.path.exists(self.status):
                sys.exit(f"no {what} on the screen:\n{screen}")
            time.sleep(0.1)

    def end(self):
        """The exit status of the program."""
        end = time.monotonic() + PATIENCE_S
        while not os.path.exists(self.status):
            if time.monotonic() > end:
                sys.exit(f"it does not end:\n{self.screen()}")
            time.sleep(0.1)
        self.tmux("kill-server")
        with open(self.status, encoding="ascii") as file:
            return int(file.read())


def expect(what, expected, actual):
    """Ends the test when two values differ."""
    global checked
    checked += 1
    if expected != actual:
        sys.exit(f"{what}: expected {expected!r}, got {actual!r}")


def shows(screen, axes, words):
    """Every axis has a line of its own, every key is there, and nothing is wider or longer than the terminal."""
    lines = screen.split("\n")
    expect("lines of the screen", True, len(lines) <= LINES + 1)
    expect("columns of the screen", True, all(len(line) <= COLUMNS for line in lines))
    for name in axes:
        with_name = [line for line in lines if name in line.replace("│", " ").split()]
        if len(with_name) != 1 or "streaming" not in with_name[0]:
            sys.exit(f"{name} has no line that says its state:\n{screen}")
        expect(name, 1, len(with_name))
    flat = " ".join(screen.split())
    for word in words:
        if word not in flat:
            sys.exit(f"{word!r} is not on the screen:\n{screen}")
        expect(word, True, word in flat)


def motion(folder, names, last):
    """A motion of a minute that begins and ends at rest."""
    path = os.path.join(folder, f"{names[0]}.csv")
    rows = [(0, 0), (1, last), (59, last), (60, 0 if names[0].endswith("rpm") else last)]
    with open(path, "w", encoding="ascii") as file:
        print("time_s", *names, sep=",", file=file)
        for seconds, value in rows:
            print(seconds, *[value] * len(names), sep=",", file=file)
    return path


def bench(motionctl, folder, drives):
    """Simulated drives behind an adapter."""
    adapter = os.path.join(folder, "can")
    process = subprocess.Popen([motionctl, "bench", "--drives", drives, "--slcan", adapter],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    # Also where a check ends this program.
    atexit.register(process.kill)
    end = time.monotonic() + PATIENCE_S
    while not os.path.exists(adapter):
        if time.monotonic() > end:
            sys.exit("the bench did not make its adapter")
        time.sleep(0.02)
    return process, adapter


def stop(process):
    """Ends the bench."""
    process.send_signal(signal.SIGINT)
    process.wait(timeout=PATIENCE_S)


def servos_in_a_simulation(motionctl, folder):
    """Fourteen axes, whose time can be slowed down."""
    path = motion(folder, NAMES, 360)
    terminal = Terminal(folder, [motionctl, "sim", "--live", "--trajectory", path, "--cycle-us", "2000"])
    screen = terminal.wait_for("streaming axes", lambda text: text.count("streaming") >= len(NAMES))
    shows(screen, NAMES, ["up/down select", "space pause", "+ - 1 speed", "s stop", "a alarm", "p pull/plug", "f [ ] time", "q quit"])
    terminal.press("-", "-")
    terminal.wait_for("slower motion", lambda text: "80 %" in text)
    terminal.press("s")
    terminal.wait_for("end", lambda text: "q leave" in text or "q quit" in text and "stopped" in text)
    terminal.press("q")
    expect("exit status of the simulation", True, terminal.end() in (0, 1, 130))


def servos_on_a_bus(motionctl, folder):
    """Fourteen axes on a bench."""
    path = motion(folder, NAMES, 360)
    process, adapter = bench(motionctl, folder, "1-14")
    terminal = Terminal(folder, [motionctl, "run", "--live", "--slcan", adapter, "--trajectory", path, "--cycle-us", "10000", "--yes"])
    screen = terminal.wait_for("streaming axes", lambda text: text.count("streaming") >= len(NAMES))
    shows(screen, NAMES, ["up/down select", "space pause", "+ - 1 speed", "s stop on the path", "Ctrl-C stop", "q stop and leave"])
    terminal.press("Space")
    terminal.wait_for("pause", lambda text: "PAUSED" in text)
    # The terminal makes a signal of it, as of any other program's.
    terminal.press("C-c")
    terminal.wait_for("end", lambda text: "stopped by the user" in text)
    terminal.press("q")
    expect("exit status of the run", 130, terminal.end())
    stop(process)


def wheels_on_a_bus(motionctl, folder):
    """Two hub motors on a bench."""
    names = ["left_rpm", "right_rpm"]
    path = motion(folder, names, 60)
    process, adapter = bench(motionctl, folder, "zlac:4,5")
    terminal = Terminal(folder, [motionctl, "run", "--live", "--drives", "zlac:4,5", "--slcan", adapter, "--trajectory", path, "--yes"])
    screen = terminal.wait_for("streaming wheels", lambda text: text.count("streaming") >= 2)
    shows(screen, names, ["up/down select", "s stop", "q stop and leave", "r/min"])
    terminal.press("s")
    terminal.wait_for("end", lambda text: "Stopped by the user" in text)
    terminal.press("q")
    expect("exit status of the wheels", 130, terminal.end())
    stop(process)


def main():
    """Runs everything."""
    motionctl = os.path.abspath(sys.argv[1])
    for views in (servos_in_a_simulation, servos_on_a_bus, wheels_on_a_bus):
        folder = tempfile.mkdtemp(prefix="motionctl-terminal-")
        try:
            views(motionctl, folder)
        finally:
            server = os.path.join(folder, "tmux.socket")
            subprocess.run(["tmux", "-S", server, "kill-server"], check=False, capture_output=True)
            shutil.rmtree(folder)
    print(f"three live views in {COLUMNS} x {LINES}: {checked} checks")


main()
