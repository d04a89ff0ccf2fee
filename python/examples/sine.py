"""A sine on two axes, as a generator: python sine.py /dev/ttyACM0 [--seconds 10]

Warning: the axes move. They swing 500 counts to both sides of where they stand; Ctrl-C brings them to rest along their path.
"""

from __future__ import annotations

import argparse
import math
from typing import Iterator, List, Tuple

import motion_board as mb

AMPLITUDE = 500.0
PERIOD_S = 4.0
RAMP_S = 1.0
RATE_HZ = 50


def sine(seconds: float) -> Iterator[Tuple[float, List[float]]]:
    """Set-points of a sine that begins and ends at rest: the second axis follows a quarter of a period later."""
    for step in range(round(seconds * RATE_HZ) + 1):
        time = step / RATE_HZ
        ramp = min(1.0, time / RAMP_S, (seconds - time) / RAMP_S)
        swing = AMPLITUDE * ramp * ramp * (3.0 - 2.0 * ramp)
        phase = 2.0 * math.pi * time / PERIOD_S
        yield time, [swing * math.sin(phase), swing * math.cos(phase)]


def main() -> None:
    """Opens the board, enables the drives, and swings."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("port", help="serial port of the board, or tcp:127.0.0.1:PORT")
    arguments.add_argument("--seconds", type=float, default=10.0)
    given = arguments.parse_args()
    with mb.Board.open(given.port) as board:
        print(board.info())
        board.enable()
        result = board.stream(sine(given.seconds), relative=True, progress=show)
        print(f"\n{result.set_points} set-points in {result.time_s:.1f} s")


def show(progress: mb.Progress) -> None:
    """One line that is written again and again."""
    print(f"\r{progress.time_s:6.1f} s  {progress.phase:8}  {progress.positions}", end="", flush=True)


if __name__ == "__main__":
    main()
