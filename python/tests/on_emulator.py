"""Runs the test of a given board against the real image in the emulator: python on_emulator.py CARGO FOLDER

CARGO is the program, FOLDER is for the port and the settings. The emulator runs until the test has ended.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from test_board import AXIS, SETTINGS

HERE = Path(__file__).resolve().parent
# The emulator and the image are built before.
PATIENCE_S = 1_200


def main() -> int:
    """The status of the test."""
    cargo, folder = sys.argv[1], Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    settings, port, log = folder / "board.toml", folder / "port", folder / "emulator.log"
    settings.write_text(SETTINGS + "".join(AXIS.format(drive=drive, gear=4096) for drive in (1, 2)))
    port.unlink(missing_ok=True)
    command = [cargo, "xtask", "emulate", "--link", str(port), "--", "--drives", "1,2", "--settings", str(settings)]
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
        tests = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(HERE / "test_given_board.py")]
        done = subprocess.run(tests, env={**os.environ, "MOTION_BOARD": str(port)}, check=False)
        if done.returncode:
            print(log.read_text()[-4000:])
        return done.returncode
    finally:
        os.killpg(emulator.pid, signal.SIGTERM)
        emulator.wait(30)


if __name__ == "__main__":
    sys.exit(main())
