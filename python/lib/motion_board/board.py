"""The link to a motion board."""

from __future__ import annotations

import itertools
import math
import time
import warnings
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Callable, Dict, Generator, Iterator, List, Optional, Sequence, Tuple, Type, Union

from . import _native
from .errors import BoardError, ConnectionLost, InputError, Refused, StreamStopped
from .set_points import Points, Scale, each_point, pairs, scales

__all__ = [
    "AxisSnapshot",
    "Board",
    "Counters",
    "Event",
    "Fault",
    "Info",
    "Origin",
    "Progress",
    "Settings",
    "Snapshot",
    "StreamResult",
]

_ACTIVE = ("Waiting", "Moving", "Dry")
_ON = ("GettingReady", "Enabled", "Homing", "Stopping", "Halted")
# What the board says when set-points come behind the end of a stream: too late, or after a stop.
_LATE, _ENDED, _NO_ENTRY = 12, 13, 35
# What boards without homing, and those of before, say to a question about it.
_UNSUPPORTED, _MESSAGE = 36, 37
_POLL_S = 0.05
# A day, as for a homing.
_LONGEST_S = 86_400


@dataclass(frozen=True)
class Info:
    """What a board is."""

    board: str
    """The board."""
    firmware: str
    """The version of the firmware."""
    boot: int
    """The number of its start: another one than before says that it was reset."""
    cycle_us: int
    """The cycle in microseconds."""
    uptime: int
    """Cycles since the start."""
    axes: int
    """Number of axes; 0 without settings."""
    segments: int
    """Ways between set-points that the board keeps."""
    settings: int
    """Most bytes of settings."""
    faults: int
    """Entries of the fault log."""


@dataclass(frozen=True)
class AxisSnapshot:
    """An axis, in command counts."""

    target: int
    """Its set-point."""
    position: int
    """Its position."""
    error: int
    """Its following error."""
    fault: int
    """The number of its fault, 0 for none."""


@dataclass(frozen=True)
class Origin:
    """What the positions of an axis count from."""

    is_known: bool
    """Whether that is known: False for an axis whose settings ask for a homing, and which is not homed. It takes no set-points."""
    is_homed: bool
    """Whether it was homed; else its positions are those of its drive."""
    counts: int
    """What its drive counts at the zero of the axis; 0 where it was not homed."""
    uncertainty: int
    """By how much that may be off, in counts."""


@dataclass(frozen=True)
class Snapshot:
    """How everything is."""

    cycle: int
    """The cycle of the board."""
    state: str
    """"NoSettings", "Locked", "StopOpen", "EnableInactive", "Off", "GettingReady", "Enabled", "Homing", "Stopping", "Faulted" or "Halted"."""
    stream: int
    """The number of the stream that was begun last."""
    phase: str
    """What becomes of it: "Idle", "Waiting", "Moving", "Dry", "Complete", "DriedUp", "Stopped" or "Displaced"."""
    time_cycles: int
    """Cycles of the stream that have passed."""
    finished: int
    """Ways between set-points that were played to their end."""
    percent: int
    """Speed of the stream at this moment."""
    axes: List[AxisSnapshot]
    """The axes."""

    @property
    def is_moving(self) -> bool:
        """Whether a stream moves the axes, or may do so yet."""
        return self.phase in _ACTIVE

    @property
    def positions(self) -> List[int]:
        """Position of each axis."""
        return [axis.position for axis in self.axes]

    @property
    def targets(self) -> List[int]:
        """Set-point of each axis."""
        return [axis.target for axis in self.axes]


@dataclass(frozen=True)
class Event:
    """Something that has happened on the board."""

    number: int
    """One more than that of the event before."""
    kind: str
    """"State", "Stream", "Fault", "Claimed", "Released", "SilentHost", "Homed", or "Lost": so many events could not be kept."""
    values: Dict[str, Any]
    """What is known of it: "state"; "stream", "phase", "finished"; "axis", "code", "detail"; "session"; "axis", "counts", "uncertainty"; "count"."""


@dataclass(frozen=True)
class Fault:
    """An entry of the fault log."""

    number: int
    """Counts the faults of the board for ever."""
    boot: int
    """The number of the start in which it happened: :attr:`Info.boot`."""
    uptime_ms: int
    """Milliseconds since the start of the firmware."""
    firmware: str
    """Its version."""
    axis: Optional[int]
    """The axis, where it is about one."""
    code: int
    """The number of the fault."""
    detail: int
    """What else is known of it."""
    place: str
    """The place in the program, for a panic."""

    @property
    def text(self) -> str:
        """What has happened, in words."""
        return _native.fault_text(self.code, self.detail)


@dataclass(frozen=True)
class Counters:
    """What came in at the board, and what was lost. A sum ends at its largest value."""

    frames: int
    """Messages that were right."""
    losses: Dict[str, int]
    """Messages that were lost, by why."""
    repeated: int
    """Requests that were repeated and answered again."""
    refused: int
    """Requests that were refused."""
    unanswered: int
    """Requests that were not answered, because nobody took the bytes."""
    snapshots_left_out: int
    """Snapshots that were left out for the same reason."""
    events_lost: int
    """Events that were overwritten before this program took them."""
    segments: int
    """Ways between set-points that were taken."""
    silent_hosts: int
    """Hosts that were silent for too long."""
    late_cycles: int
    """Cycles that were late."""


@dataclass(frozen=True)
class Settings:
    """The settings of a board: the drives on its bus, and what they may do.

    ``settings.counts_per_turn`` is the ``counts_per_unit`` of positions in turns of the motors.
    """

    data: bytes
    """As the board stores them; empty for a board without settings, which moves nothing."""

    @classmethod
    def of_text(cls, text: str) -> "Settings":
        """From the text of a file, as ``motionctl board settings`` reads and writes it.

        Raises :class:`motion_board.CodecError` with line and column.
        """
        return cls(_native.settings_of_text(text))

    @property
    def text(self) -> str:
        """As the text of a file (TOML).

        Raises :class:`motion_board.CodecError` for no settings, and for those of another version.
        """
        return _native.read_settings(self.data)[0]

    @property
    def values(self) -> Dict[str, Any]:
        """Every value: "name", "bus", "inputs" and "axes" with "drive", "gear", "speed_rpm", "acceleration_rpm_per_s", "travel" ..."""
        return _native.read_settings(self.data)[1]

    @property
    def counts_per_turn(self) -> List[int]:
        """Command counts of a turn of each motor."""
        return _native.read_settings(self.data)[2]


@dataclass(frozen=True)
class Progress:
    """How far a stream is."""

    time_s: float
    """Time of the stream that has passed on the board."""
    sent: int
    """Set-points that were handed over so far."""
    phase: str
    """As :attr:`Snapshot.phase`."""
    percent: int
    """Speed at this moment."""
    positions: List[int]
    """Position of each axis, in counts."""


@dataclass(frozen=True)
class StreamResult:
    """A stream that is complete."""

    set_points: int
    """Set-points that were played."""
    time_s: float
    """From the first to the last."""


class Board:
    """A motion board that takes orders.

    Nothing is enabled and nothing moves that was not asked for. What may move, and how fast, is in the settings of the board, and the board
    refuses everything beyond; wrong shapes, times and numbers are refused before anything is sent. A thread keeps the board informed that
    the program lives; when the program ends or hangs up, the board stops the axes along their path by itself. It is no emergency stop:
    build your own, in hardware.

        >>> with Board.open("/dev/ttyACM0") as board:
        ...     board.enable()
        ...     board.stream(times, positions)
    """

    def __init__(self, link: _native.Link, commands: bool) -> None:
        """Use :meth:`open`."""
        self._link = link
        self._commands = commands
        self._info: Optional[Info] = None

    @classmethod
    def open(
        cls,
        address: str,
        *,
        baud: int = 921_600,
        commands: bool = True,
        timeout_s: float = 3.0,
    ) -> "Board":
        """Connects to a board and claims the command; nothing is switched on.

        ``address``: a serial port or a pseudo-terminal ("/dev/ttyACM0", "COM3"), or "tcp:127.0.0.1:PORT". ``baud``: bit rate of a real
        serial port. ``commands``: False only reads, beside another program that commands. ``timeout_s``: how long to wait for an answer.

        Raises :class:`motion_board.NotConnected`.
        """
        _deadline(timeout_s)
        link = _native.Link(address, baud, commands)
        board = cls(link, commands)
        try:
            link.connect(timeout_s)
            board._info = board.info()
        except BaseException:
            link.close()
            raise
        return board

    def __enter__(self) -> "Board":
        """Itself; with the block everything is disabled and closed."""
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        error: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        """Stops along the path, disables, and closes."""
        try:
            if self._commands and not self._link.is_closed():
                self.disable()
        except BoardError as reason:
            if error is None:
                raise
            # The error of the block is the one to see.
            warnings.warn(f"the drives may be on: {reason}", RuntimeWarning, stacklevel=2)
        finally:
            self.close()

    def close(self) -> None:
        """Gives the command back and closes the port; a stream is stopped along its path. The drives stay as they are."""
        self._link.close()

    # What the board says.

    def info(self) -> Info:
        """What the board is."""
        return Info(**self._link.info())

    @property
    def axes(self) -> int:
        """Number of axes; 0 without settings."""
        return self.info().axes

    @property
    def settings(self) -> Settings:
        """The settings in force, read from the board."""
        return Settings(self._link.settings())

    def write_settings(self, settings: Settings) -> None:
        """Lets the board check settings and store them, while no drive is enabled; they count from its next start on.

        Raises :class:`motion_board.Refused` for settings that make no board that works: the old ones stay.
        """
        self._link.write_settings(settings.data)

    def snapshot(self) -> Snapshot:
        """How everything is, of a moment after this call."""
        return _snapshot(self._link.snapshot(2.0))

    def events(self) -> List[Event]:
        """What has happened since the last call, oldest first."""
        events, lost = self._link.events()
        told = [_event(number, event) for number, event in events]
        return [Event(-1, "Lost", {"count": lost}), *told] if lost else told

    def faults(self) -> List[Fault]:
        """The fault log, latest first."""
        entries: List[Fault] = []
        for index in itertools.count():
            try:
                fault = Fault(**self._link.fault(index))
            except Refused as refused:
                if refused.number != _NO_ENTRY:
                    raise
                break
            # One that happens meanwhile moves all others on by a place.
            if not entries or fault.number < entries[-1].number:
                entries.append(fault)
        return entries

    def counters(self) -> Counters:
        """What came in at the board, and what was lost."""
        return Counters(**self._link.counters())

    # Commands.

    def enable(self, timeout_s: float = 10.0) -> None:
        """Switches the drives on, and waits until they are.

        Warning: the motors hold their position from here on.
        """
        deadline = _deadline(timeout_s)
        self._link.command("enable", 0)
        self._wait_for(("Enabled",), ("GettingReady",), "enabled", deadline)

    def disable(self, timeout_s: float = 10.0) -> None:
        """Stops along the path, switches the drives off, and waits until they are: a `timeout_s` that is none ends the waiting alone."""
        try:
            self.stop(timeout_s)
        finally:
            # Whatever became of the stop.
            self._end("disable")
        off = ("Off", "NoSettings", "Locked", "StopOpen", "EnableInactive", "Faulted")
        self._wait_for(off, _ON, "off", _deadline(timeout_s))

    def home(self, timeout_s: float = 120.0) -> None:
        """Finds the origin of each axis whose settings ask for it, one after the other, and waits until they are found.

        The drives must be enabled. Their positions count from there for :meth:`stream` until they are not enabled any more. Any exception,
        Ctrl-C included, stops the axes before it is raised.

        Warning: the motors turn, as the settings say: to a switch, or against a stop.

        Raises :class:`motion_board.Refused` with the axis and the reason when one is not found, or when something has ended it.
        """
        # Here, because what goes wrong below stops the axes.
        _deadline(timeout_s)
        try:
            self._link.home(timeout_s)
        except Refused:
            raise
        except BaseException:
            try:
                self.stop()
            except BoardError as reason:
                warnings.warn(f"the homing could not be stopped: {reason}", RuntimeWarning, stacklevel=2)
            raise

    def origins(self) -> List[Origin]:
        """What the positions of each axis count from."""
        origins: List[Origin] = []
        for axis in range(self.axes):
            try:
                origins.append(_origin(self._link.origin(axis)))
            except Refused as refused:
                if refused.number not in (_UNSUPPORTED, _MESSAGE):
                    raise
                return [_OF_DRIVE] * self.axes
        return origins

    def stop(self, timeout_s: float = 30.0) -> None:
        """Slows down along the path, and waits until the axes stand: a `timeout_s` that is none ends the waiting alone."""
        # The order comes first: a wrong time is no reason to go on.
        self._end("stop")
        deadline = _deadline(timeout_s)
        while True:
            snapshot = self.snapshot()
            if not snapshot.is_moving and snapshot.state not in ("Homing", "Stopping"):
                return
            if time.monotonic() > deadline:
                raise BoardError(f"the axes did not stop in {timeout_s} s: the board is {_words(snapshot)}")
            if snapshot.is_moving:
                # Another thread or another program may have begun it at the same moment.
                self._link.command("stop", 0)

    def _end(self, command: str) -> None:
        try:
            self._link.command(command, 0)
        except Refused:
            # A board without settings refuses every command; it has no drives that move or are on.
            if self.snapshot().state != "NoSettings":
                raise

    def halt(self) -> None:
        """Ends all set-points at once; the axes stop as hard as the drives let them. The drives keep their power, and follow nothing until
        :meth:`enable`. For a stop along the path there is :meth:`stop`."""
        self._link.command("halt", 0)

    def clear(self) -> None:
        """Forgets faults whose cause is gone; nothing is switched on."""
        self._link.command("clear", 0)

    def pause(self) -> None:
        """Slows the stream down along its path, and holds it there."""
        self._link.command("pause", 0)

    def resume(self) -> None:
        """Goes on after :meth:`pause`."""
        self._link.command("resume", 0)

    def set_override(self, percent: int) -> None:
        """The speed of the stream: 0 to 200 percent; the board keeps it within its limits."""
        if not 0 <= percent <= 200:
            raise InputError(f"percent: expected 0 to 200, got {percent}")
        self._link.command("override", percent)

    def stream(
        self,
        times: Union[Sequence[float], Any, Points],
        positions: Optional[Union[Sequence[Sequence[float]], Any]] = None,
        *,
        counts_per_unit: Scale = 1.0,
        relative: bool = False,
        when_dry: str = "end",
        percent: int = 100,
        progress: Optional[Callable[[Progress], None]] = None,
    ) -> StreamResult:
        """Plays set-points, and returns when the axes stand at the last one.

        ``times``: seconds, ascending. ``positions``: one row a time, one column an axis: lists, or arrays of numpy. Or ``times`` alone:
        any iterable or generator of ``(time, positions)``, taken as the board has room, so it may be endless. Between set-points the
        axes follow a curve without steps of velocity and acceleration, at rest at the first and the last one. 10 to 100 set-points a second
        are usual.

        The first set-point must be where the axes stand (:attr:`Snapshot.targets`); with ``relative`` positions count from there, and
        the first one is 0. Positions of an axis that was homed count from its origin (:meth:`origins`). ``counts_per_unit``: counts of a unit of the positions, for all axes or for each. ``when_dry``: what happens
        when set-points come too late: the axes come to rest along the path in any case, and that is the "end", or they "wait" for more.
        ``percent``: speed, 0 to 200. ``progress``: is called about ten times a second.

        Any exception, Ctrl-C included, stops the axes along their path before it is raised.

        Raises :class:`motion_board.InputError` before anything is sent, for a list or an array as a whole, for a generator set-point by
        set-point; :class:`motion_board.Refused` with the index of the set-point that the board refuses;
        :class:`motion_board.StreamStopped` when it ended early; :class:`motion_board.ConnectionLost`.
        """
        playing = self.play(
            times,
            positions,
            counts_per_unit=counts_per_unit,
            relative=relative,
            when_dry=when_dry,
            percent=percent,
        )
        while True:
            try:
                step = next(playing)
            except StopIteration as end:
                result: StreamResult = end.value
                return result
            if progress is not None:
                try:
                    progress(step)
                except BaseException:
                    playing.close()
                    raise

    def play(
        self,
        times: Union[Sequence[float], Any, Points],
        positions: Optional[Union[Sequence[Sequence[float]], Any]] = None,
        *,
        counts_per_unit: Scale = 1.0,
        relative: bool = False,
        when_dry: str = "end",
        percent: int = 100,
    ) -> Generator[Progress, None, StreamResult]:
        """:meth:`stream` as an iterator: nothing moves before the first step is taken, and an iterator that is closed stops the axes.

        >>> for progress in board.play(times, positions):
        ...     print(progress.time_s, progress.positions)
        """
        if when_dry not in ("end", "wait"):
            raise InputError(f'when_dry: expected "end" or "wait", got {when_dry!r}')
        if not 0 <= percent <= 200:
            raise InputError(f"percent: expected 0 to 200, got {percent}")
        source, is_whole = pairs(times, positions)
        axes = self.axes
        factors = scales(counts_per_unit, axes)
        points: Iterator[Tuple[float, List[float]]] = each_point(source, axes)
        if is_whole:
            # Nothing is sent of what is wrong anywhere.
            whole = list(points)
            if not whole:
                raise InputError("expected at least one set-point, got none")
            points = iter(whole)
        return self._play(points, factors, relative, when_dry == "wait", percent)

    def _play(
        self,
        points: Iterator[Tuple[float, List[float]]],
        factors: List[float],
        relative: bool,
        waits: bool,
        percent: int,
    ) -> Generator[Progress, None, StreamResult]:
        cycle_us = self.info().cycle_us
        first = next(points, None)
        if first is None:
            raise InputError("expected at least one set-point, got none")
        zeros = self.snapshot().targets if relative else [origin.counts for origin in self.origins()]
        base = [float(at) for at in zeros]
        start = first[0]

        def counts(row: List[float]) -> List[float]:
            return [zero + factor * at for zero, factor, at in zip(base, factors, row)]

        def cycles(moment: float) -> float:
            return (moment - start) * 1e6 / cycle_us

        sent, last = 1, start
        number = self._link.begin(0.0, counts(first[1]), waits, percent)
        try:
            due = time.monotonic()
            for moment, row in points:
                is_open = self._link.push(number, cycles(moment), counts(row))
                sent, last = sent + 1, moment
                if not is_open:
                    self._raise_end(number)
                if time.monotonic() >= due:
                    due = time.monotonic() + 2 * _POLL_S
                    yield self._progress(number, sent, cycle_us, percent)
            if not self._link.finish(number):
                self._raise_end(number)
            while self._is_under_way(number):
                if time.monotonic() >= due:
                    due = time.monotonic() + 2 * _POLL_S
                    yield self._progress(number, sent, cycle_us, percent)
                self._link.wait_for_news(_POLL_S)
        except BaseException:
            self._stop_stream(number)
            raise
        return StreamResult(sent, last - start)

    def _is_under_way(self, number: int) -> bool:
        """Whether a stream of which everything was handed over goes on; an early end is an exception."""
        end = self._stream_end(number)
        if end == "sending":
            return True
        if end in ("lost", "timed-out"):
            raise ConnectionLost("the connection was lost in the stream: the board stops the axes by itself")
        if end == "sent":
            # Of a moment after everything was taken, so that it knows the stream, unless another one has begun or the board was reset.
            snapshot = self.snapshot()
            if snapshot.stream == number and snapshot.is_moving:
                return True
        played = self._link.played(number)
        if played is None or played["phase"] != "Complete":
            self._raise_stopped(number)
        return False

    def _stream_end(self, number: int) -> str:
        try:
            return self._link.stream_end(number)
        except Refused as refused:
            if refused.number in (_LATE, _ENDED):
                self._raise_stopped(number)
            raise

    def _raise_end(self, number: int) -> None:
        """The stream takes no set-points any more: says why."""
        self._is_under_way(number)
        self._raise_stopped(number)

    def _raise_stopped(self, number: int) -> None:
        snapshot = self._rest_of(number)
        # A board that has said nothing of it was told to stop before it has begun it.
        played = self._link.played(number) or {"phase": "Stopped", "time_cycles": 0}
        time_s = played["time_cycles"] * self.info().cycle_us / 1e6
        why = {
            "DriedUp": "the set-points came too late: send them earlier, or fewer of them",
            "Stopped": "it was stopped",
            "Displaced": "the axes were moved before it began",
        }.get(played["phase"], "it ended early")
        raise StreamStopped(
            f"the stream ended at {time_s:.3f} s: {why}; the board is {_words(snapshot)}", played["phase"], time_s
        )

    def _stop_stream(self, number: int) -> None:
        """Brings the axes to rest along the path; the error that led here is the one to see."""
        if self._link.is_closed():
            # That has stopped it.
            return
        try:
            if self._link.stop_stream(number):
                self._rest_of(number, 30.0)
        except BoardError as reason:
            warnings.warn(f"the stream could not be stopped: {reason}", RuntimeWarning, stacklevel=3)

    def _rest_of(self, number: int, timeout_s: float = math.inf) -> Snapshot:
        """Waits until a stream that has ended moves nothing any more."""
        deadline = time.monotonic() + timeout_s
        while True:
            snapshot = self.snapshot()
            is_over = not snapshot.is_moving and snapshot.state != "Stopping"
            if is_over or snapshot.stream != number:
                return snapshot
            if time.monotonic() > deadline:
                raise BoardError(f"the axes did not stop in {timeout_s} s: the board is {_words(snapshot)}")

    def _progress(self, number: int, sent: int, cycle_us: int, percent: int) -> Progress:
        latest = self._link.latest_snapshot()
        snapshot = self.snapshot() if latest is None else _snapshot(latest)
        if snapshot.stream != number:
            # It has not begun, as far as the board has said.
            return Progress(0.0, sent, "Waiting", percent, snapshot.positions)
        time_s = snapshot.time_cycles * cycle_us / 1e6
        return Progress(time_s, sent, snapshot.phase, snapshot.percent, snapshot.positions)

    def _wait_for(self, wanted: Tuple[str, ...], on_the_way: Tuple[str, ...], words: str, deadline: float) -> None:
        while True:
            snapshot = self.snapshot()
            if snapshot.state in wanted:
                return
            if snapshot.state not in on_the_way:
                raise BoardError(f"the board is not {words}: it is {_words(snapshot)}")
            if time.monotonic() > deadline:
                raise BoardError(f"the board was not {words} in time: it is {_words(snapshot)}")


_OF_DRIVE = Origin(is_known=True, is_homed=False, counts=0, uncertainty=0)


def _origin(told: Any) -> Origin:
    if isinstance(told, dict):
        return Origin(is_known=True, is_homed=True, **told["Found"])
    return _OF_DRIVE if told == "OfDrive" else Origin(is_known=False, is_homed=False, counts=0, uncertainty=0)


def _deadline(timeout_s: float) -> float:
    if not 0 <= timeout_s <= _LONGEST_S:
        raise InputError(f"timeout_s: expected 0 to {_LONGEST_S} s, got {timeout_s}")
    return time.monotonic() + timeout_s


def _words(snapshot: Snapshot) -> str:
    faults = [f"axis {axis} has fault {one.fault}" for axis, one in enumerate(snapshot.axes) if one.fault]
    return ", ".join([snapshot.state, *faults])


def _snapshot(fields: Dict[str, Any]) -> Snapshot:
    player = fields["player"]
    return Snapshot(
        cycle=fields["cycle"],
        state=fields["state"],
        stream=fields["stream"],
        phase=player["phase"],
        time_cycles=player["time_cycles"],
        finished=player["finished"],
        percent=player["percent"],
        axes=[AxisSnapshot(**axis) for axis in fields["axes"]],
    )


def _event(number: int, event: Dict[str, Any]) -> Event:
    [(kind, values)] = event.items()
    return Event(number, kind, values if isinstance(values, dict) else {"state": values})
