"""A board without a machine, for tests of programs that command one.

    >>> from motion_board.testing import SimulatedBoard
    >>> with SimulatedBoard(axes=2) as simulated, motion_board.Board.open(simulated.address) as board:
    ...     board.enable()
    ...     board.stream([0.0, 0.5], [[0, 0], [100, -100]])
    ...     simulated.positions()
    [100, -100]

It is the board's end of the link with its checks and its player, as the firmware has them, on a TCP port of this machine and in real time.
The axes are where their set-points are: there are no drives, no bus, no stops and no switches; where axes find their origins you say.
``motionctl bench --board`` has those.
"""

from __future__ import annotations

from types import TracebackType
from typing import List, NamedTuple, Optional, Sequence, Tuple, Type

from . import _native
from .arguments import BytesLike, octets, row, whole
from .errors import InputError

__all__ = ["SetPoint", "SimulatedBoard"]

_UNITS = 1 << 24


def _origins(origins: Sequence[Optional[int]]) -> List[Optional[int]]:
    try:
        given = row(origins)
    except TypeError as error:
        raise InputError(f"origins: {error}") from error
    return [
        None if at is None else whole(f"origins, axis {axis}", at, -(1 << 31), (1 << 31) - 1)
        for axis, at in enumerate(given)
    ]


class SetPoint(NamedTuple):
    """What the axes were told in one cycle."""

    cycle: int
    """The cycle of the board."""
    positions: List[float]
    """Of each axis, in counts."""


class SimulatedBoard:
    """A board whose axes follow at once."""

    def __init__(
        self,
        axes: int = 2,
        *,
        velocity: float = 100.0,
        acceleration: float = 1.5,
        jerk: Optional[float] = None,
        travel: Tuple[int, int] = (-1_000_000, 1_000_000),
        cycle_us: int = 1000,
        silence_cycles: int = 500,
        settings: BytesLike = b"",
        port: int = 0,
        origins: Sequence[Optional[int]] = (),
    ) -> None:
        """Starts it.

        ``axes``: 1 to 14. ``velocity``, ``acceleration``, ``jerk``: limits of every axis in counts per cycle, per cycle² and per cycle³
        (None: not limited); of these a stream may need all of the velocity, two thirds of the acceleration, half of the jerk.
        ``travel``: lowest and highest position in counts. ``silence_cycles``: a host that is silent for so long is a stop.
        ``settings``: what it has as its settings, and does not obey; what is written counts from :meth:`reset` on. ``port``: of TCP, 0 for one that is free.
        ``origins``: an axis with a number is one that is to be homed; its homing takes a fifth of a second, finds its origin there, and brings it there.
        """
        self._board = _native.SimulatedBoard(
            axes,
            velocity,
            acceleration,
            jerk,
            travel,
            cycle_us,
            silence_cycles,
            octets("settings", settings),
            whole("port", port, 0, 0xFFFF),
            _origins(origins),
        )

    @property
    def address(self) -> str:
        """For :meth:`motion_board.Board.open`."""
        return self._board.address

    @property
    def axes(self) -> int:
        """Number of axes."""
        return self._board.axes

    def positions(self) -> List[int]:
        """Where the axes stand, in counts."""
        return self._board.positions()

    def trace(self, clear: bool = False) -> List[SetPoint]:
        """Every set-point so far, one for each cycle in which a stream moved or held the axes; ``clear`` forgets them.

        Raises ``RuntimeError`` when there were more than fit, 240,000.
        """
        data, lost = self._board.trace(clear)
        if lost:
            raise RuntimeError(f"the trace is full: {lost} set-points were not kept; clear it in between")
        numbers = memoryview(data).cast("q").tolist()
        row = self.axes + 1
        return [
            SetPoint(numbers[at], [units / _UNITS for units in numbers[at + 1 : at + row]])
            for at in range(0, len(numbers), row)
        ]

    def open_stop_circuit(self) -> None:
        """The stop circuit opens: set-points end at once."""
        self._board.set_stop_circuit_open(True)

    def close_stop_circuit(self) -> None:
        """It closes: the drives stay off until they are enabled."""
        self._board.set_stop_circuit_open(False)

    def set_enable_input(self, active: bool) -> None:
        """The enable input."""
        self._board.set_enable_input_active(active)

    def raise_fault(self, axis: int, code: int, detail: int = 0) -> None:
        """An axis fails: set-points end at once, the fault log has one entry more. ``code``: from 1."""
        self._board.raise_fault(axis, code, detail)

    def reset(self) -> None:
        """As if it were switched off and on: the axes stay where they are, the fault log and the settings that were written last are kept,
        everything else begins anew."""
        self._board.reset()

    def drop_link(self) -> None:
        """Cuts the host off, as if the cable were pulled; another one may come."""
        self._board.drop_link()

    def close(self) -> None:
        """Ends it."""
        self._board.close()

    def __enter__(self) -> "SimulatedBoard":
        """Itself; it ends with the block."""
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        error: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        """Ends it."""
        self.close()
