"""What can go wrong: each error says what was expected, what came, and what to do."""

from __future__ import annotations

from typing import Any, Optional, Tuple

__all__ = [
    "BoardError",
    "CodecError",
    "ConnectionLost",
    "InputError",
    "LogError",
    "MotionBoardError",
    "NoReply",
    "NotConnected",
    "Refused",
    "StreamStopped",
]


class MotionBoardError(Exception):
    """Any error of this package."""


class InputError(MotionBoardError, ValueError):
    """An argument that makes no sense; nothing was done."""


class CodecError(MotionBoardError, ValueError):
    """A message that cannot be encoded, or a frame that does not decode."""


class LogError(MotionBoardError, ValueError):
    """A line of a log that cannot be read.

    ``file``: the name of the log. ``line``: from 1. ``column``: from 1, or None where the place in the line is not known.
    ``reason``: what was expected, and what came.
    """

    def __init__(self, file: str, line: int, column: Optional[int], reason: str) -> None:
        self.file = file
        self.line = line
        self.column = column
        self.reason = reason
        place = f"{file}:{line}" if column is None else f"{file}:{line}:{column}"
        super().__init__(f"{place}: {reason}")

    def __reduce__(self) -> Tuple[Any, ...]:
        """For pickle, with the arguments."""
        return type(self), (self.file, self.line, self.column, self.reason), self.__dict__


class BoardError(MotionBoardError):
    """The board cannot be reached, or does not do what it was asked for."""


class NotConnected(BoardError):
    """The port cannot be opened, or no board answers behind it."""


class ConnectionLost(BoardError):
    """The connection was lost. What was under way has ended for this program; the board stops its axes along their path by itself."""


class NoReply(BoardError):
    """A request had no reply. Whether it was carried out is not known: read :meth:`motion_board.Board.snapshot`."""


class Refused(BoardError):
    """The board refuses a request: nothing of it moves anything.

    ``number``: the number of the reason, which never changes; ``reason``: its name, None where this version does not know it.
    ``axis``: the axis, from 0, where it is about one. ``expected``, ``actual``: both values in ``unit`` ("" where there is nothing to
    compare). ``advice``: what to do. ``index``: the set-point of a stream, from 0, whose way is refused, where it is about one.
    """

    def __init__(
        self,
        message: str,
        number: int,
        reason: Optional[str],
        axis: Optional[int],
        expected: float,
        actual: float,
        unit: str,
        advice: str,
        index: Optional[int] = None,
    ) -> None:
        self.number = number
        self.reason = reason
        self.axis = axis
        self.expected = expected
        self.actual = actual
        self.unit = unit
        self.advice = advice
        self.index = index
        self._message = message
        super().__init__(message if index is None else f"set-point {index}: {message}")

    def __reduce__(self) -> Tuple[Any, ...]:
        """For pickle, with the arguments."""
        values = (self.number, self.reason, self.axis, self.expected, self.actual, self.unit, self.advice, self.index)
        return type(self), (self._message, *values), self.__dict__


class StreamStopped(BoardError):
    """A stream ended before its last set-point, because it was stopped, ran dry, or the machine stopped.

    ``phase``: what became of it, as :attr:`motion_board.Snapshot.phase`; ``time_s``: how far it got.
    """

    def __init__(self, message: str, phase: str, time_s: float) -> None:
        self.phase = phase
        self.time_s = time_s
        super().__init__(message)

    def __reduce__(self) -> Tuple[Any, ...]:
        """For pickle, with the arguments."""
        return type(self), (str(self), self.phase, self.time_s), self.__dict__
