"""A gamepad moves two axes: its stick gives the velocity, releasing it brings them to rest; its first button ends it.

python gamepad.py /dev/ttyACM0 [--joystick /dev/input/js0] [--speed 2000]

Warning: the axes move, as far as the settings of the board let them. The set-points are sent 0.3 s ahead of the motion, so the axes follow
the stick that much later. A gamepad is no enabling device: build your own emergency stop, in hardware.
"""

from __future__ import annotations

import argparse
import os
import struct
import time
from typing import Callable, Iterable, Iterator, List, NamedTuple, Optional, Tuple

import motion_board as mb

RATE_HZ = 50
DEAD_ZONE = 0.15
# struct js_event of <linux/joystick.h>: time in ms, value, type, number.
EVENT = struct.Struct("IhBB")
BUTTON, AXIS, INITIAL = 0x01, 0x02, 0x80


class Stick(NamedTuple):
    """What a gamepad says now."""

    x: float
    """-1 to 1."""
    y: float
    """-1 to 1."""
    ends: bool
    """The first button is pressed."""


def joystick(path: str) -> Iterator[Stick]:
    """A joystick of Linux: how it is, as often as one asks. It ends when the device is gone."""
    values, ends = [0.0, 0.0], False
    device = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    try:
        while True:
            try:
                data = os.read(device, EVENT.size * 64)
                if not data:
                    return
                for _, value, kind, number in EVENT.iter_unpack(data[: len(data) // EVENT.size * EVENT.size]):
                    if kind & ~INITIAL == AXIS and number < 2:
                        values[number] = value / 32767.0
                    elif kind & ~INITIAL == BUTTON and number == 0 and value:
                        ends = True
            except BlockingIOError:
                pass
            except OSError:
                return
            yield Stick(values[0], values[1], ends)
    finally:
        os.close(device)


def set_points(
    sticks: Iterable[Stick],
    speed: float,
    acceleration: float,
    wait: Optional[Callable[[float], None]] = None,
) -> Iterator[Tuple[float, List[float]]]:
    """Set-points of the stick, in counts from where the axes stand. Velocities follow the stick with a limited acceleration.

    ``speed`` in counts per second, ``acceleration`` in counts per second². ``wait`` is called with the time of each set-point, and returns
    when it has come; without it real time is kept. When the sticks end, or their button is pressed, the axes come to rest.
    """
    begin = time.monotonic()
    keep = wait if wait is not None else (lambda moment: time.sleep(max(0.0, begin + moment - time.monotonic())))
    positions, velocities = [0.0, 0.0], [0.0, 0.0]
    yield 0.0, list(positions)
    source, step, is_ending = iter(sticks), 0, False
    while True:
        step += 1
        stick = next(source, None) if not is_ending else None
        is_ending = is_ending or stick is None or stick.ends
        wanted = (0.0, 0.0) if stick is None or is_ending else (shaped(stick.x), shaped(stick.y))
        most = acceleration / RATE_HZ
        for axis in range(2):
            change = speed * wanted[axis] - velocities[axis]
            velocities[axis] += max(-most, min(most, change))
            positions[axis] += velocities[axis] / RATE_HZ
        keep(step / RATE_HZ)
        yield step / RATE_HZ, list(positions)
        if is_ending and velocities == [0.0, 0.0]:
            # Once more, so that the curve ends without a step.
            yield (step + 1) / RATE_HZ, list(positions)
            return


def shaped(value: float) -> float:
    """Nothing around the middle, and fine control beside it; what is no number is no motion."""
    if not abs(value) > DEAD_ZONE:
        return 0.0
    size = min(1.0, (abs(value) - DEAD_ZONE) / (1.0 - DEAD_ZONE))
    return size * size if value > 0 else -size * size


def drive(board: mb.Board, sticks: Iterable[Stick], speed: float, acceleration: float) -> mb.StreamResult:
    """Plays the stick until it ends."""
    return board.stream(set_points(sticks, speed, acceleration), relative=True, when_dry="wait")


def main() -> None:
    """Opens the gamepad and the board."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("port", help="serial port of the board, or tcp:127.0.0.1:PORT")
    arguments.add_argument("--joystick", default="/dev/input/js0")
    arguments.add_argument("--speed", type=float, default=2000.0, help="counts per second at the end of the stick")
    arguments.add_argument("--acceleration", type=float, default=4000.0, help="counts per second squared")
    given = arguments.parse_args()
    sticks = joystick(given.joystick)
    next(sticks)
    with mb.Board.open(given.port) as board:
        board.enable()
        print("move the stick; the first button ends it")
        result = drive(board, sticks, given.speed, given.acceleration)
        print(f"{result.time_s:.1f} s")


if __name__ == "__main__":
    main()
