"""Set-points as programs have them, checked before anything is done with them."""

from __future__ import annotations

import math
from typing import Any, Callable, Iterable, Iterator, List, Optional, Sequence, Tuple, Union

from .arguments import number, refuse_unordered, row, shown
from .errors import InputError

__all__ = ["Points", "Scale", "all_points", "each_point", "scales"]

Points = Iterable[Tuple[float, Sequence[float]]]
"""Times in seconds with the positions of the axes."""
Scale = Union[float, Sequence[float]]
"""Counts of a unit, for all axes or for each."""


def all_points(times: Any, positions: Any = None) -> List[Tuple[float, List[float]]]:
    """Every set-point, checked: shapes, numbers, order of the times."""
    return list(each_point(_pairs(times, positions)))


def each_point(points: Iterable[Any], axes: Optional[int] = None) -> Iterator[Tuple[float, List[float]]]:
    """Set-points as they come, checked one by one; ``axes``: as many positions, None for as many as the first one has."""
    before = -math.inf
    for index, point in enumerate(points):
        time, positions = _point(index, point)
        axes = len(positions) if axes is None else axes
        if len(positions) != axes or not positions:
            raise InputError(
                f"set-point {index}: expected {axes or 'at least one'} positions, one for each axis, got {len(positions)}"
            )
        if time <= before:
            raise InputError(f"set-point {index}: expected a time after {before} s, got {time} s")
        before = time
        yield time, positions


def _point(index: int, point: Any) -> Tuple[float, List[float]]:
    try:
        time, positions = row(point)
        positions = row(positions)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"set-point {index}: expected a time and a row of positions, got {shown(point)}: {error}"
        ) from error
    return (
        _finite(time, lambda: f"set-point {index}: expected a time in seconds"),
        [
            _finite(at, lambda: f"set-point {index}, axis {axis}: expected a position")
            for axis, at in enumerate(positions)
        ],
    )


def _finite(value: Any, expected: Callable[[], str]) -> float:
    """A number; the words are made where they are needed alone."""
    try:
        found = number(value)
    except (TypeError, ValueError, OverflowError):
        found = math.nan
    if not math.isfinite(found):
        raise InputError(f"{expected()}, got {shown(value)}")
    return found


def _pairs(times: Any, positions: Any) -> Iterable[Any]:
    if positions is None:
        return _points(times)
    times, positions = _column(times, "times"), _column(positions, "positions")
    if len(times) != len(positions):
        raise InputError(
            f"expected as many rows of positions as times: got {len(times)} times and {len(positions)} rows"
        )
    return zip(times, positions)


def _points(points: Any) -> Iterable[Any]:
    try:
        refuse_unordered(points)
        iterator: Iterator[Any] = iter(points)
    except TypeError as error:
        raise InputError(f"times without positions: expected pairs of a time and a row of positions: {error}") from error
    return iterator


def _column(values: Any, name: str) -> Sequence[Any]:
    try:
        return row(values)
    except TypeError as error:
        raise InputError(f"{name}: {error}") from error


def pairs(times: Any, positions: Any) -> Tuple[Iterable[Any], bool]:
    """Times and positions as pairs, and whether all of them are there already."""
    is_whole = positions is not None or isinstance(times, (list, tuple)) or hasattr(times, "tolist")
    return _pairs(times, positions), is_whole


def scales(counts_per_unit: Scale, axes: int) -> List[float]:
    """One factor for each axis."""
    given: Any = counts_per_unit
    is_one = not hasattr(given, "__iter__") or getattr(given, "ndim", None) == 0
    factors = [given] * axes if is_one else _column(given, "counts_per_unit")
    if len(factors) != axes:
        raise InputError(f"counts_per_unit: expected one for each of {axes} axes, got {len(factors)}")
    return [_factor(factor, axis) for axis, factor in enumerate(factors)]


def _factor(value: Any, axis: int) -> float:
    expected = f"counts_per_unit, axis {axis}: expected a number other than 0"
    factor = _finite(value, lambda: expected)
    if factor == 0.0:
        raise InputError(f"{expected}, got {factor}")
    return factor
