"""Runs the tests of a given board against the real image in the emulator: python on_emulator.py CARGO FOLDER

CARGO is the program, FOLDER is for the port and the settings. The emulator runs until a test has ended.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Sequence

from test_board import AXIS, SETTINGS

HERE = Path(__file__).resolve().parent
# What an axis has when its origin is at the low end of its shaft, and at a switch.
TO_A_STOP = """
torque_poll_us = 20000
homing = "stop"
homing_direction = "negative"
homing_way_millidegrees = 1440000
homing_reference_millidegrees = -18000
"""
TO_A_SWITCH = """
homing = "switch"
homing_direction = "positive"
homing_way_millidegrees = 1440000
homing_switch_pin = 3
homing_switch_active = "high"
"""
# The emulator and the image are built before.
PATIENCE_S = 1_200


def on_board(cargo: str, folder: Path, settings: str, options: Sequence[str], drives: Sequence[str], variable: str, test: str) -> int:
    """The status of a test of the image that takes orders."""
    written, port, log = folder / "board.toml", folder / "port", folder / "emulator.log"
    written.write_text(settings)
    port.unlink(missing_ok=True)
    command = [cargo, "xtask", "emulate", "--link", str(port), *options, "--", *drives, "--settings", str(written)]
    with log.open("w") as said:
        # Its standard input stays open: it takes lines.
        emulator = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=said, stderr=subprocess.STDOUT, start_new_session=True
        )
    try:
        deadline = time.monotonic() + PATIENCE_S
        while not port.exists():
            if emulator.poll() is not None or time.monotonic() > deadline:
                print(log.read_text())
                print("the emulator did not start")
                return 1
            time.sleep(0.1)
        tests = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(HERE / test)]
        done = subprocess.run(tests, env={**os.environ, variable: str(port)}, check=False)
        if done.returncode:
            print(log.read_text()[-4000:])
        return done.returncode
    finally:
        os.killpg(emulator.pid, signal.SIGTERM)
        emulator.wait(30)


def main() -> int:
    """The status of the tests."""
    cargo, folder = sys.argv[1], Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    drives = ["--drives", "1,2"]
    axes = [AXIS.format(drive=drive, gear=4096) for drive in (1, 2)]
    streamed = on_board(cargo, folder, SETTINGS + "".join(axes), [], drives, "MOTION_BOARD", "test_given_board.py")
    homed = SETTINGS + axes[0] + TO_A_STOP + axes[1] + TO_A_SWITCH
    beside = [*drives, "--stops=-0.5:1.5", "--switch", "2:0.5"]
    at_home = on_board(cargo, folder, homed, ["--homing"], beside, "HOMED_BOARD", "test_given_home.py")
    return streamed or at_home


if __name__ == "__main__":
    sys.exit(main())
