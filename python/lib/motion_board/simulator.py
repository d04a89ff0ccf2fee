"""A motion on simulated drives, in virtual time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, Iterable, List, Optional, Sequence, Tuple, Union

from . import _native
from .arguments import drive_ids, real, whole
from .errors import InputError
from .set_points import Points, Scale, all_points, scales

__all__ = ["AxisResult", "Simulation", "simulate"]


@dataclass(frozen=True)
class AxisResult:
    """One axis at the end."""

    axis: int
    """From 0."""
    drive: int
    """Drive id."""
    state: str
    """State of the axis in the master."""
    fault: Optional[str]
    """Its fault."""
    set_points: int
    """Set-points that the controller of the master accepted, since power-on."""
    target_counts: int
    """Way from the first set-point to the last."""
    sent_counts: int
    """Sum of the steps in the master's books."""
    received_counts: int
    """Sum of the steps that the drive received."""
    position_error_counts: int
    """Target less position of the motor, at the end."""


@dataclass(frozen=True)
class Simulation:
    """What became of a motion. It can be pickled and copied; ``dataclasses.asdict`` cannot copy its tables, ``vars`` gives them as they are."""

    promises_kept: bool
    """Each drive received exactly its target, no cycle was late, nothing failed."""
    axes: List[AxisResult]
    """Axis by axis."""
    cycle_us: int
    """Time from one cycle to the next."""
    bit_rate_kbit: int
    """Bit rate of the bus."""
    cycles: int
    """Cycles of the motion."""
    late_cycles: int
    """Cycles whose set-points had not all ended on the wire when the next one began."""
    late_hand_overs: int
    """Cycles that the master could not hand to its controller in time, since power-on."""
    faults: int
    """Faults."""
    mean_bus_load: float
    """From 0 to 1."""
    set_points: "memoryview[Any]"
    """Set-points in counts, one row a cycle and one column an axis: ``.tolist()`` for lists, ``numpy.asarray(...)`` for an array."""
    positions: "memoryview[Any]"
    """Positions of the motors at the end of each cycle, of the same shape; a motor follows its set-points with a delay."""

    def times(self) -> List[float]:
        """The begin of each cycle, in seconds from the first set-point."""
        return [cycle * self.cycle_us / 1e6 for cycle in range(self.cycles)]

    def __reduce__(self) -> Tuple[Any, ...]:
        """For pickle, with the tables as bytes."""
        fields = dict(vars(self))
        tables = {name: fields.pop(name).tobytes() for name in ("set_points", "positions")}
        return _restored, (type(self), fields, tables)


def simulate(
    times: Union[Sequence[float], Any, Points],
    positions: Optional[Union[Sequence[Sequence[float]], Any]] = None,
    *,
    drives: Optional[Iterable[int]] = None,
    counts_per_unit: Scale = 1.0,
    bit_rate_kbit: int = 1000,
    cycle_us: int = 1000,
    max_rpm: float = 500.0,
    max_acceleration: float = 5000.0,
    max_jerk: Optional[float] = None,
    seed: int = 1,
) -> Simulation:
    """Plays a motion on simulated DYN drives: the firmware's master on a bus with exact times; nothing is real.

    ``times``: seconds, ascending; the first one is the start. ``positions``: one row a time, one column an axis: lists, or arrays of numpy. Or ``times`` alone:
    any iterable of ``(time, positions)``. The axes stand at the first set-point; between set-points they follow the curve that a board
    follows, too. ``drives``: drive id of each axis, 1, 2, 3 ... without. ``counts_per_unit``: counts of a unit of the positions, for all
    axes or for each; at most 14 axes. The simulated drives have 16384 counts a turn. ``max_rpm``, ``max_acceleration`` (r/min per second), ``max_jerk``
    (r/min per s²; None: not limited): a motion that needs more is refused. ``seed``: of the response times.

    Raises :class:`motion_board.InputError` for a motion that cannot be played, with the index of the set-point.
    """
    points = all_points(times, positions)
    if not points:
        raise InputError("expected at least one set-point, got none")
    axes = len(points[0][1])
    ids = list(range(1, axes + 1)) if drives is None else drive_ids("drives", drives)
    factors = scales(counts_per_unit, axes)
    cycle_us = whole("cycle_us", cycle_us, 250, 1_000_000)
    start = points[0][0]
    scaled = [
        ((time - start) * 1e6 / cycle_us, [at * factor for at, factor in zip(row, factors)])
        for time, row in points
    ]
    set_points, motors, summary = _native.simulate(
        scaled,
        {
            "drives": ids,
            "bit_rate_kbit": whole("bit_rate_kbit", bit_rate_kbit, 10, 1000),
            "cycle_us": cycle_us,
            "max_rpm": real("max_rpm", max_rpm),
            "max_acceleration": real("max_acceleration", max_acceleration),
            "max_jerk": None if max_jerk is None else real("max_jerk", max_jerk),
            "seed": whole("seed", seed, 0, (1 << 64) - 1),
        },
    )
    results = [AxisResult(**axis) for axis in summary.pop("axes")]
    return Simulation(
        axes=results,
        set_points=_table(set_points, axes),
        positions=_table(motors, axes),
        **summary,
    )


def _restored(kind: Any, fields: Dict[str, Any], tables: Dict[str, bytes]) -> Simulation:
    axes = len(fields["axes"])
    result: Simulation = kind(**fields, **{name: _table(numbers, axes) for name, numbers in tables.items()})
    return result


def _table(numbers: bytes, columns: int) -> "memoryview[Any]":
    rows = len(numbers) // 8 // columns
    return memoryview(numbers).cast("q", (rows, columns))
