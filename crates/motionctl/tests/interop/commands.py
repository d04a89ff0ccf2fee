"""Every command in a block of README and documents, run as it stands there, against simulated drives.

Usage: commands.py MOTIONCTL

The commands of a document run one after the other in a folder of their own, with the drives of a bench in the place of real ones: a link that a
block names is that of the bench. A comment `<!-- bench: OPTIONS -->` before a block starts one, and so does a block that starts a bench. What asks
is answered with --yes. Output that is shown under a block must be among what its commands print. What cannot run here is in ELSEWHERE, with the
reason.

What is checked is that the commands are right, and not how well this computer keeps time: a command that fails is tried again.
"""

import atexit
import contextlib
import os
import pty
import re
import select
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = os.getcwd()
PATIENCE_S = 120
# What runs until it is told to end has that long.
WATCHED_S = 3

# What cannot run here: the begin of a command, and why.
ELSEWHERE = {
    "cargo test": "the step `test`",
    "cargo xtask": "the steps themselves",
    "cargo fw": "the step `firmware`",
    "cargo run --release --target": "it needs a board and probe-rs",
    "cargo install": "it would install the tool for this user; the step `packages` builds it",
    "motionctl limits": "the step `limits`",
    "tshark": "the step `wireshark`",
    "candump -L can0 | cantools": "the step `dbc`",
    "cantools": "the step `dbc`",
    "dcfchk": "the step `eds`",
    "dcfgen": "the step `eds`",
    "producer |": "there is no such program; examples/stream.py stands for it",
    "echo \"override 50\" | nc": "not every machine has nc; the tests of the stream give the same orders",
    "sudo ip link": "it needs an adapter and root; the step `socketcan` does it in a kernel of its own",
    "motionctl run --bus pcan:": "it needs two buses; tests of the tool run a motion on two",
    "examples/twist_stream.py |": "it drives for as long as somebody presses keys",
}

# What ends with another status than 0, because that is what it shows: promises that were broken, settings that differ.
STATUS = [(re.compile("^motionctl sim --faults"), (1,)), (re.compile("^motionctl restore .*--compare"), (0, 1))]

# A motion that takes long is made shorter.
SHORTER = [("--seconds 60", "--seconds 2")]

# What a document takes for granted.
FILES = {
    "plan.csv": "time_s,a_deg,b_deg\n0,0,0\n0.5,90,-45\n1,180,-90\n",
    "FILE.csv": "time_s,a\n0,0\n0.5,90\n1,180\n",
    "wheels.csv": "time_s,left_rpm,right_rpm\n0,0,0\n0.5,60,-60\n1,0,0\n",
    "part.ngc": "G21 G90 F600\nG1 X5\nG1 Y-5\nM2\n",
}

# How often a command is tried: motions run in real time, and a machine that is busy with other things lets a bench wait.
ATTEMPTS = 4
REST_S = 3

BENCH = re.compile(r"<!-- bench: (.*?) -->")
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```\n", re.DOTALL | re.MULTILINE)
# Waits for somebody who sends set-points.
STREAM = re.compile(r"(--stream|board stream) tcp")
LINK = re.compile(r"(/dev/tty\w+|COM\d+|(?<=--slcan )tcp:\d+|(?<=--serial )tcp:\d+|/tmp/can-adapter|/tmp/drive-port|/tmp/board|--can can0|--can pcan:\w+)(?=\s|$)")
# Languages of blocks with commands; those for Windows are run with links of this system.
SHELLS = ("sh", "console", "bat")
PLACES = ["/var/log/can", "/tmp/motion"]

checked = 0
used = set()


class Bench:
    """Simulated drives, whose adapter and serial port are in a folder."""

    def __init__(self, folder, options):
        self.adapter, self.serial, self.board = (os.path.join(folder, name) for name in ("adapter", "port", "board"))
        words = shlex.split(options.replace("/tmp/board", self.board))
        links = ["--slcan", self.adapter]
        if not any("zlac" in word for word in words):
            links += ["--serial", self.serial]
        # Their errors are those of the drives, which the commands tell.
        self.process = subprocess.Popen([MOTIONCTL, "bench", *words, *links], cwd=folder,
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        # Also where a check ends this program.
        atexit.register(self.process.kill)
        end = time.monotonic() + PATIENCE_S
        while not os.path.exists(self.adapter):
            if time.monotonic() > end or self.process.poll() is not None:
                sys.exit(f"no bench with {options}")
            time.sleep(0.02)
        # The drives are ready 150 ms after power-on.
        time.sleep(0.5)

    def stop(self):
        self.process.send_signal(signal.SIGINT)
        self.process.wait(timeout=PATIENCE_S)


def blocks(path):
    """Language, text and what stands between a block and the one before it."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    end = 0
    for found in BLOCK.finditer(text):
        yield found[1], found[2], text[end:found.start()]
        end = found.end()


def commands(text, language):
    """The commands of a block without their comments."""
    for line in text.splitlines():
        if language == "console":
            if not line.startswith("$ "):
                continue
            line = line[2:]
        line = re.sub(r"(^|\s)#.*$", "", line).strip()
        if line:
            yield line


def as_tool(command):
    """What the aliases of cargo stand for."""
    command = re.sub(r"^cargo motionctl(?=\s|$)", "motionctl", command)
    return re.sub(r"^cargo sim( --)?(?=\s|$)", "motionctl sim", command)


class Document:
    """A document under way."""

    def __init__(self, path):
        self.path = path
        self.folder = tempfile.mkdtemp(prefix="motionctl-commands-")
        for name, text in FILES.items():
            with open(os.path.join(self.folder, name), "w", encoding="ascii") as file:
                file.write(text)
        for name in ("examples", "interop"):
            os.symlink(os.path.join(ROOT, name), os.path.join(self.folder, name))
        os.mkdir(os.path.join(self.folder, "bin"))
        os.symlink(MOTIONCTL, os.path.join(self.folder, "bin", "motionctl"))
        os.makedirs(os.path.join(self.folder, ".local/share/bash-completion/completions"))
        self.environment = dict(os.environ, HOME=self.folder, PATH=f"{self.folder}/bin:{os.environ['PATH']}")
        self.run_plain("motionctl sim --candump last-night.log")
        self.bench = None
        self.background = []
        self.said = []

    def fail(self, command, why):
        sys.exit(f"{self.path}: {command}: {why}")

    def here(self, command):
        """The command with the link of the bench, and files in the folder."""
        for name in PLACES:
            command = command.replace(name, os.path.join(self.folder, os.path.basename(name)))
        for long, short in SHORTER:
            command = command.replace(long, short)

        def link(found):
            if self.bench is None:
                self.fail(command, "no bench is known for its link")
            before = command[:found.start()].split()
            if before[:2] == ["motionctl", "board"]:
                return self.bench.board
            is_serial = bool(before) and before[-1] == "--serial"
            place = self.bench.serial if is_serial else self.bench.adapter
            return f"--slcan {place}" if found[0].startswith("--can") else place
        return LINK.sub(link, command)

    def run_plain(self, command):
        return subprocess.run(["sh", "-c", command], cwd=self.folder, env=self.environment, check=False, timeout=PATIENCE_S,
                              stdin=subprocess.DEVNULL, capture_output=True, text=True)

    def run(self, command):
        """A command of the document."""
        global checked
        for begin in ELSEWHERE:
            if as_tool(command).startswith(begin):
                used.add(begin)
                return
        tool = as_tool(command)
        checked += 1
        if not tool.startswith("examples/stream.py"):
            # The commands of a block are different ways to use the same link.
            self.close_block()
        words = tool.split()
        if words[:2] == ["motionctl", "bench"]:
            self.start_bench(re.sub(r"--(slcan|serial|can)\s+\S+", "", tool[len("motionctl bench"):]))
            return
        tool = self.here(tool)
        print(f"  {command}", flush=True)
        if "--live" in words:
            self.watch(command, tool)
        elif STREAM.search(tool) or " monitor " in tool or " record " in tool:
            self.start(command, tool)
        else:
            self.finish(command, tool)

    def start_bench(self, options):
        """Other drives in the place of those that were there."""
        if self.bench is not None:
            self.bench.stop()
        self.bench = Bench(self.folder, options)

    def finish(self, command, tool):
        """A command that ends by itself."""
        expected = next((statuses for begin, statuses in STATUS if begin.search(tool)), (0,))
        for _ in range(ATTEMPTS):
            done = self.run_plain(tool)
            if done.returncode == 2 and "Scripts confirm with --yes" in done.stderr:
                done = self.run_plain(f"{tool} --yes")
            if done.returncode in expected:
                break
            last = (done.stderr.strip().splitlines() or [""])[-1]
            print(f"    once more: exit status {done.returncode}, {last}", flush=True)
            time.sleep(REST_S)
        if done.returncode not in expected:
            self.fail(command, f"exit status {done.returncode}\n{done.stdout}{done.stderr}")
        self.said.append(done.stdout)
        is_told_to_restart = "assign-id" in tool and "zlac" not in tool or "speed-resolution-divider" in tool
        if is_told_to_restart or "board settings set" in tool:
            # As the command says and the documents do: the power is switched off and on.
            self.bench.process.send_signal(signal.SIGUSR1)
            time.sleep(1)

    def start(self, command, tool):
        """A command that runs until it is told to end."""
        asks = "--yes" if "motionctl run" in tool or "board stream" in tool else ""
        child = subprocess.Popen(["sh", "-c", f"exec {tool} {asks}"], cwd=self.folder, env=self.environment,
                                 stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        time.sleep(WATCHED_S)
        if STREAM.search(tool):
            # Somebody sends to it, or nobody does.
            self.background.append((command, child))
        else:
            self.end(command, child)

    def end(self, command, child):
        if child.poll() is None:
            child.send_signal(signal.SIGINT)
        output, errors = child.communicate(timeout=PATIENCE_S)
        if child.returncode not in (0, 130):
            self.fail(command, f"exit status {child.returncode}\n{output}{errors}")
        self.said.append(output)

    def watch(self, command, tool):
        """A command that takes the terminal."""
        asks = " --yes" if "motionctl run" in tool else ""
        child, terminal = pty.fork()
        if child == 0:
            os.chdir(self.folder)
            os.environ.update(self.environment, TERM="xterm-256color", COLUMNS="80", LINES="24")
            os.execvp("sh", ["sh", "-c", f"stty cols 80 rows 24; exec {tool}{asks}"])
        end = time.monotonic() + PATIENCE_S
        shown, streams_since, has_pressed = b"", None, False
        while True:
            with contextlib.suppress(OSError):
                if select.select([terminal], [], [], 0.1)[0]:
                    shown += os.read(terminal, 4096)
            if b"streaming" in shown and streams_since is None:
                streams_since = time.monotonic()
            # The motion itself is seen for a while.
            if streams_since is not None and time.monotonic() > streams_since + WATCHED_S and not has_pressed:
                os.write(terminal, b"q")
                has_pressed = True
            ended, status = os.waitpid(child, os.WNOHANG)
            if ended:
                break
            if time.monotonic() > end:
                os.kill(child, signal.SIGKILL)
                self.fail(command, "it does not end")
        os.close(terminal)
        if not has_pressed or os.waitstatus_to_exitcode(status) not in (0, 130):
            self.fail(command, f"status {status}\n{shown.decode(errors='replace')}")

    def compare(self, language, text):
        """What is shown under a block is among what it printed, or in a file that it wrote."""
        global checked
        if language == "toml":
            names = [name for name in os.listdir(self.folder) if name.endswith(".toml")]
            printed = ""
            for name in names:
                with open(os.path.join(self.folder, name), encoding="utf-8") as file:
                    printed += file.read()
        else:
            printed = "".join(self.said)
        # Columns are as wide as the longest of all lines, of which a document shows some.
        lines = {" ".join(line.split()) for line in printed.splitlines()}
        for line in text.splitlines():
            checked += 1
            if line.strip() and " ".join(line.split()) not in lines:
                self.fail("the output shown", f"{line!r} is not in\n{printed[-3000:]}")

    def close_block(self):
        for command, child in self.background:
            self.end(command, child)
        self.background = []

    def close(self):
        if self.bench is not None:
            self.bench.stop()
        shutil.rmtree(self.folder)


def run(path):
    """Runs a document."""
    print(path, flush=True)
    document = Document(path)
    is_output = False
    for language, text, before in blocks(path):
        for options in BENCH.findall(before):
            document.start_bench(options)
        if language in SHELLS:
            document.said = []
            for command in commands(text, language):
                document.run(command)
            document.close_block()
            is_output = True
            continue
        if language in ("text", "toml") and is_output and not BENCH.sub("", before).strip():
            document.compare(language, text)
        elif language in ("csv", "toml") and re.findall(rf"`([\w.-]+\.{language})`", before):
            # A file that the text before names.
            place = os.path.join(document.folder, re.findall(rf"`([\w.-]+\.{language})`", before)[-1])
            if language == "csv" or not os.path.exists(place):
                with open(place, "w", encoding="ascii") as file:
                    file.write(text)
        is_output = False
    document.close()


def main():
    """Runs every document that shows a command."""
    documents = ["README.md", "CONTRIBUTING.md"]
    for folder in ("docs", *sorted(f"crates/{name}" for name in os.listdir("crates"))):
        documents += sorted(f"{folder}/{name}" for name in os.listdir(folder) if name.endswith(".md"))
    chosen = sys.argv[2:] or documents
    for path in chosen:
        if any(language in SHELLS for language, _, _ in blocks(path)):
            run(path)
    unused = set(ELSEWHERE) - used
    if unused and not sys.argv[2:]:
        sys.exit(f"in ELSEWHERE, and in no document: {sorted(unused)}")
    print(f"commands of the documents: {checked} checks, {len(used)} kinds of command are run elsewhere")


MOTIONCTL = os.path.abspath(sys.argv[1])
main()
