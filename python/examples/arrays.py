"""A motion as arrays of numpy: tried on simulated drives first, then played by a board: python arrays.py [/dev/ttyACM0]

Warning: with a port the axes move.
"""

from __future__ import annotations

import sys
from typing import Any, Tuple

import numpy as np

import motion_board as mb

COUNTS_PER_TURN = 16384


def motion() -> Tuple[Any, Any]:
    """Two axes go half a turn and back, the second one the other way; 40 set-points a second."""
    times = np.arange(0.0, 3.001, 0.025)
    turns = 0.25 * (1.0 - np.cos(2.0 * np.pi * times / 3.0))
    # The acceleration begins at 0, too.
    turns *= np.sin(np.pi * times / 3.0) ** 2
    return times, np.column_stack([turns, -turns])


def main() -> None:
    """Plan, simulation, board."""
    times, turns = motion()
    print("the bus carries the axes:", bool(mb.plan(axes=turns.shape[1])))
    done = mb.simulate(times, turns, counts_per_unit=COUNTS_PER_TURN)
    targets, motors = np.asarray(done.set_points), np.asarray(done.positions)
    print(f"simulated: {done.cycles} cycles, {done.late_cycles} late, every promise kept: {done.promises_kept}")
    print(f"largest distance of a motor from its set-point: {np.abs(targets - motors).max()} counts")
    if len(sys.argv) > 1:
        with mb.Board.open(sys.argv[1]) as board:
            board.enable()
            result = board.stream(times, turns, counts_per_unit=COUNTS_PER_TURN, relative=True)
            print(f"played: {result.set_points} set-points in {result.time_s:.1f} s")


if __name__ == "__main__":
    main()
