"""Homing, halt and what follows on a board that somebody else has started: HOMED_BOARD is its port.

``cargo xtask emulate --link /tmp/board --homing -- --drives 1,2 --stops=-0.5:1.5 --switch 2:0.5 --settings board.toml`` runs the real
firmware behind a pseudo-terminal, with drive 1 between stops and a switch beside the shaft of drive 2.
"""

from __future__ import annotations

import os

import pytest

from motion_board import Board, Refused

PORT = os.environ.get("HOMED_BOARD")
TURN = 4 * 4096


@pytest.mark.skipif(PORT is None, reason="HOMED_BOARD names no board")
def test_a_given_board_homes_follows_and_forgets_at_a_halt() -> None:
    assert PORT is not None
    with Board.open(PORT, timeout_s=10.0) as board:
        board.enable()
        with pytest.raises(Refused) as not_homed:
            board.stream([0.0, 1.0], [[0, 0], [100, 0]], relative=True)
        assert not_homed.value.number == 41
        board.home()
        stop, switch = board.origins()
        # The stop is half a turn below, and 18 degrees beside the zero; the switch is half a turn above.
        assert abs(stop.counts - (-TURN // 2 + TURN // 20)) <= stop.uncertainty + 2
        assert abs(switch.counts - TURN // 2) <= switch.uncertainty + 2
        before = board.snapshot().targets
        board.stream([0.0, 0.5, 1.0], [[0, 0], [TURN // 2, -TURN // 2], [TURN // 2, -TURN // 2]], relative=True)
        after = board.snapshot().targets
        assert [end - start for start, end in zip(before, after)] == [TURN // 2, -TURN // 2]
        board.halt()
        board.stop()
        assert board.snapshot().state == "Halted"
        assert not any(origin.is_known for origin in board.origins())
        board.enable()
        with pytest.raises(Refused) as forgotten:
            board.stream([0.0, 1.0], [[0, 0], [100, 0]], relative=True)
        assert forgotten.value.number == 41
        board.disable()
        assert board.counters().late_cycles == 0
        assert all(axis.fault == 0 for axis in board.snapshot().axes)
