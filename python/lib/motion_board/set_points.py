"""Set-points as programs have them, checked before anything is done with them."""

from __future__ import annotations

import math
from typing import Any, Iterable, Iterator, List, Optional, Sequence, Tuple, Union

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
        try:
            time, row = point
            time, row = float(time), [float(at) for at in _row(row)]
        except (TypeError, ValueError) as error:
            raise InputError(
                f"set-point {index}: expected a time and a row of positions, got {point!r}"
            ) from error
        axes = len(row) if axes is None else axes
        if len(row) != axes or not row:
            raise InputError(
                f"set-point {index}: expected {axes or 'at least one'} positions, one for each axis, got {len(row)}"
            )
        if not math.isfinite(time):
            raise InputError(f"set-point {index}: expected a time in seconds, got {time}")
        if time <= before:
            raise InputError(f"set-point {index}: expected a time after {before} s, got {time} s")
        for axis, at in enumerate(row):
            if not math.isfinite(at):
                raise InputError(f"set-point {index}, axis {axis}: expected a position, got {at}")
        before = time
        yield time, row


def _pairs(times: Any, positions: Any) -> Iterable[Any]:
    if positions is None:
        return times  # type: ignore[no-any-return]
    times, positions = _row(times), _row(positions)
    if len(times) != len(positions):
        raise InputError(
            f"expected as many rows of positions as times: got {len(times)} times and {len(positions)} rows"
        )
    return zip(times, positions)


def pairs(times: Any, positions: Any) -> Tuple[Iterable[Any], bool]:
    """Times and positions as pairs, and whether all of them are there already."""
    is_whole = positions is not None or isinstance(times, (list, tuple))
    return _pairs(times, positions), is_whole


def _row(values: Any) -> Sequence[Any]:
    """An array of numpy as lists, which are faster to go through; one number is a row of one."""
    listed = values.tolist() if hasattr(values, "tolist") else values
    if isinstance(listed, (int, float)):
        return [listed]
    if not hasattr(listed, "__len__"):
        return list(listed)
    return listed  # type: ignore[no-any-return]


def scales(counts_per_unit: Scale, axes: int) -> List[float]:
    """One factor for each axis."""
    factors = [float(factor) for factor in _row(counts_per_unit)]
    if isinstance(counts_per_unit, (int, float)):
        factors = factors * axes
    if len(factors) != axes:
        raise InputError(f"counts_per_unit: expected one for each of {axes} axes, got {len(factors)}")
    for axis, factor in enumerate(factors):
        if not math.isfinite(factor) or factor == 0.0:
            raise InputError(f"counts_per_unit, axis {axis}: expected a number other than 0, got {factor}")
    return factors
