"""Whether a bus carries its axes, worked out before anything moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Iterable, List, Optional, Sequence, Tuple, Union

from . import _native
from .arguments import drive_ids, row, shown, whole
from .errors import InputError

__all__ = ["Plan", "PlannedFrame", "plan"]


# A period of a microsecond.
_MOST_HZ = 1_000_000
_MOST_US = 0xFFFF_FFFF


@dataclass(frozen=True)
class PlannedFrame:
    """Frames of one kind in the worst case."""

    frame: str
    """What they are."""
    first_id: int
    """Lowest identifier."""
    last_id: int
    """Highest identifier."""
    worst_bits: int
    """Longest on the wire, with stuff bits and the pause behind it."""
    period_us: int
    """Time from one to the next."""
    jitter_us: int
    """How late it may be offered."""
    response_us: Optional[int]
    """Longest time until it is through; None: there is no bound."""
    deadline_us: int
    """When it must be through."""
    in_time: bool
    """Whether it is."""


@dataclass(frozen=True)
class Plan:
    """A verdict, for every payload, every phase of the drives and every order of their replies."""

    schedulable: bool
    """Whether every frame is in time."""
    refusal: Optional[str]
    """Why not."""
    remedies: Optional[str]
    """What would help."""
    warnings: List[str]
    """What is in doubt."""
    frames: List[PlannedFrame]
    """Every kind of frame with its worst time."""
    load_bits: int
    """What a full cycle carries."""
    cycle_bits: int
    """What fits into it."""
    most_axes: int
    """The largest number of axes with drives 1, 2, 3 ... and the same polls."""
    requests_behind: Optional[int]
    """Set-points before the requests; None for all of them."""

    def __bool__(self) -> bool:
        """Whether the plan is admitted."""
        return self.schedulable


def plan(
    axes: Union[int, Iterable[int]] = 8,
    *,
    bit_rate_kbit: int = 1000,
    cycle_us: int = 1000,
    max_step_counts: int = 16384,
    status_hz: int = 50,
    position_hz: int = 50,
    torque_hz: int = 0,
    speed_hz: int = 0,
    counter_hz: int = 0,
    requests: int = 1,
    response_us: Sequence[int] = (375, 625),
    tx_order: str = "fifo",
    any_request: bool = False,
    release_jitter_us: int = 0,
    alarms: int = 0,
    error_interval_us: Optional[int] = None,
) -> Plan:
    """Works out whether a bus carries its axes.

    ``axes``: a number of axes, with drives 1, 2, 3 ..., or their drive ids. ``bit_rate_kbit``: 10 to 1000. ``cycle_us``: 250 to
    1000000. ``max_step_counts``: largest step of an axis in a cycle. ``..._hz``: polls of each axis, 0 for none, at most 1000000. ``requests``: that may
    go out in a cycle. ``response_us``: shortest and longest response of the drives. ``tx_order``: "fifo" or "identifier".
    ``any_request``: axes are brought up while others stream. ``release_jitter_us``: how late a cycle may begin. ``alarms``: in two
    cycles, that set-points must survive. ``error_interval_us``: shortest time between two errors on the bus, None for no errors.

    A plan that is refused is no exception: ``if not plan(axes=14): ...``. Raises :class:`motion_board.InputError` for values that
    make no sense.
    """
    if isinstance(axes, (set, frozenset)):
        # Their order does not matter here.
        axes = sorted(axes)
    is_number = not hasattr(axes, "__iter__") or getattr(axes, "ndim", None) == 0
    drives = list(range(1, whole("axes", axes, 1, 63) + 1)) if is_number else drive_ids("axes", axes)
    verdict = _native.plan(
        {
            "drives": drives,
            "bit_rate_kbit": whole("bit_rate_kbit", bit_rate_kbit, 10, 1000),
            "cycle_us": whole("cycle_us", cycle_us, 250, 1_000_000),
            "max_step_counts": whole("max_step_counts", max_step_counts, 1, 16_384),
            "status_hz": whole("status_hz", status_hz, 0, _MOST_HZ),
            "position_hz": whole("position_hz", position_hz, 0, _MOST_HZ),
            "torque_hz": whole("torque_hz", torque_hz, 0, _MOST_HZ),
            "speed_hz": whole("speed_hz", speed_hz, 0, _MOST_HZ),
            "counter_hz": whole("counter_hz", counter_hz, 0, _MOST_HZ),
            "requests": whole("requests", requests, 1, 255),
            "response_us": _response(response_us),
            "tx_order": str(tx_order),
            "any_request": bool(any_request),
            "release_jitter_us": whole("release_jitter_us", release_jitter_us, 0, _MOST_US),
            "alarms": whole("alarms", alarms, 0, 255),
            "error_interval_us": None
            if error_interval_us is None
            else whole("error_interval_us", error_interval_us, 1, _MOST_US),
        }
    )
    frames = [PlannedFrame(**frame) for frame in verdict.pop("frames")]
    return Plan(frames=frames, **verdict)


def _response(response_us: Any) -> Tuple[int, int]:
    try:
        shortest, longest = row(response_us)
    except (TypeError, ValueError) as error:
        raise InputError(f"response_us: expected the shortest and the longest, got {shown(response_us)}") from error
    return whole("response_us", shortest, 0, _MOST_US), whole("response_us", longest, 0, _MOST_US)
