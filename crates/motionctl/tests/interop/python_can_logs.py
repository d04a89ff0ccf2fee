"""Logs that python-can writes, read by `motionctl decode`.

usage: python_can_logs.py MOTIONCTL

The traffic of a simulated run goes through python-can's reader of candump logs and each of its text writers. What
`motionctl decode` makes of each must be what it makes of the original, as far as the format keeps it.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import can
from can.io.trc import TRCFileVersion, TRCWriter

# What the conversation says, whatever the clock of the format.
MEANING = ("id", "extended", "remote", "data", "drive", "direction", "function", "step_counts", "position_counts")


def decode(motionctl, log):
    """The frames of a log, and everything else that was found in it."""
    run = subprocess.run([motionctl, "decode", "--json", log], capture_output=True, text=True)
    lines = [json.loads(line) for line in run.stdout.splitlines()]
    errors = [line for line in lines if line["kind"] == "error"]
    if run.returncode or errors or run.stderr:
        sys.exit(f"{log}: exit status {run.returncode}, {errors[:3]}, {run.stderr}")
    return [line for line in lines if line["kind"] == "frame"]


def meanings(frames):
    return [tuple(str(frame.get(name)) for name in MEANING) for frame in frames]


def write_all(source, folder):
    """The log in every text format of python-can."""
    logs = {suffix: folder / f"run{suffix}" for suffix in (".log", ".asc", ".csv", ".txt", ".trc")}
    writers = [can.Logger(path) for path in logs.values()]
    old_trc = TRCWriter(folder / "old.trc")
    old_trc.file_version = TRCFileVersion.V1_0
    for message in can.LogReader(source):
        for writer in [*writers, old_trc]:
            writer.on_message_received(message)
    for writer in [*writers, old_trc]:
        writer.stop()
    return [*logs.values(), folder / "old.trc"]


def main(motionctl):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        source = folder / "source.log"
        subprocess.run([motionctl, "sim", "--json", "--candump", source], check=True, capture_output=True)
        expected = decode(motionctl, source)
        if len(expected) < 10_000:
            sys.exit(f"expected the traffic of a whole run, got {len(expected)} frames")
        start_s = expected[0]["time_s"]
        for log in write_all(source, folder):
            actual = decode(motionctl, log)
            for number, (want, got) in enumerate(zip(meanings(expected), meanings(actual))):
                if want != got:
                    sys.exit(f"{log.name}, frame {number}: expected {want}, got {got}")
            if len(actual) != len(expected):
                sys.exit(f"{log.name}: expected {len(expected)} frames, got {len(actual)}")
            drift_s = (actual[-1]["time_s"] - actual[0]["time_s"]) - (expected[-1]["time_s"] - start_s)
            # TRC 1.0 has whole milliseconds.
            if abs(drift_s) > 0.002:
                sys.exit(f"{log.name}: the log is {drift_s} s longer than the original")
            print(f"{log.name}: {len(actual)} frames as in the original")


main(sys.argv[1])
