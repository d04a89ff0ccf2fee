"""The example against a board that somebody else has started: MOTION_BOARD is its port, and it has two axes.

``cargo xtask emulate --link /tmp/board -- --drives 1,2 --settings board.toml`` runs the real firmware behind a pseudo-terminal.
"""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from test_examples import EXAMPLES

from motion_board import Board

PORT = os.environ.get("MOTION_BOARD")


@pytest.mark.skipif(PORT is None, reason="MOTION_BOARD names no board")
def test_the_sine_on_a_given_board() -> None:
    assert PORT is not None
    with Board.open(PORT, timeout_s=10.0) as board:
        assert board.axes == 2, "the example has two axes"
        late = board.counters().late_cycles
        before = board.snapshot().targets
    command = [sys.executable, str(EXAMPLES / "sine.py"), PORT, "--seconds", "4"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, text=True, timeout=300)
    assert done.returncode == 0, done.stdout
    assert "201 set-points in 4.0 s" in done.stdout
    with Board.open(PORT, timeout_s=10.0, commands=False) as board:
        snapshot = board.snapshot()
        assert snapshot.state == "Off" and snapshot.phase == "Complete"
        assert snapshot.targets == before
        assert board.counters().late_cycles == late
        assert all(axis.fault == 0 for axis in snapshot.axes)
