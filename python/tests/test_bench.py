"""The link, against the simulated board of the tool: a master, a bus in real time, and drives."""

from __future__ import annotations

import os
import re
import subprocess
import time
from pathlib import Path
from typing import Callable, Iterator, Tuple

import pytest

from motion_board import Board, NotConnected, Refused, Settings
from test_board import AXIS, SETTINGS, sine, until

Bench = Tuple["subprocess.Popen[str]", str]


@pytest.fixture
def bench(tmp_path: Path, motionctl: Callable[..., str]) -> Iterator[Bench]:
    """Two drives behind a board without settings, and the address of the board."""
    program = os.environ["MOTIONCTL"]
    output = tmp_path / "bench.txt"
    with output.open("w") as said:
        running = subprocess.Popen(
            [program, "bench", "--drives", "1,2", "--board", "tcp:0", "--settings", str(tmp_path / "flash.toml"), "--inputs"],
            stdin=subprocess.PIPE,
            stdout=said,
            stderr=subprocess.STDOUT,
            text=True,
        )
    found = None
    deadline = time.monotonic() + 20
    while found is None:
        assert running.poll() is None and time.monotonic() < deadline, output.read_text()
        found = re.search(r"tcp:127\.0\.0\.1:\d+", output.read_text())
        time.sleep(0.02)
    yield running, found.group()
    running.terminate()
    running.wait(20)


def order(bench: Bench, line: str) -> None:
    stdin = bench[0].stdin
    assert stdin is not None
    stdin.write(line + "\n")
    stdin.flush()


def test_settings_then_a_motion_on_simulated_drives(bench: Bench) -> None:
    address = bench[1]
    with Board.open(address) as board:
        assert board.snapshot().state == "NoSettings" and board.axes == 0
        with pytest.raises(Refused):
            board.enable()
        text = SETTINGS + "\n[inputs]\nenable_fitted = false\n" + "".join(AXIS.format(drive=drive, gear=4096) for drive in (1, 2))
        board.write_settings(Settings.of_text(text))
    order(bench, "reset")
    deadline = time.monotonic() + 20
    while True:
        try:
            board = Board.open(address)
            if board.axes == 2:
                break
            board.close()
        except NotConnected:
            pass
        assert time.monotonic() < deadline
    with board:
        assert board.settings.values["axes"][1]["drive"] == 2
        until("the drives", lambda: board.snapshot().state == "Off")
        board.enable(timeout_s=20)
        times, rows = sine(1.5, counts=1000.0)
        result = board.stream(times, rows, relative=True)
        assert result.set_points == len(times)
        snapshot = board.snapshot()
        assert all(abs(axis.error) < 50 and axis.fault == 0 for axis in snapshot.axes)
        with pytest.raises(Refused) as caught:
            board.stream([0.0, 0.02, 0.04], [[0, 0], [5000, 0], [0, 0]], relative=True)
        assert caught.value.reason in ("Velocity", "Acceleration") and caught.value.axis == 0
        order(bench, "stop open")
        until("the open stop circuit", lambda: board.snapshot().state == "StopOpen")
        with pytest.raises(Refused) as caught:
            board.enable()
        assert caught.value.reason == "StopInput"
        order(bench, "stop closed")
        assert board.counters().late_cycles == 0
