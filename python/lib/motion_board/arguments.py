"""Arguments of every kind, checked: the errors say which one, what was expected and what came."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Mapping, Sequence, Set
from reprlib import repr as shown
from typing import Any, List, Optional, Type, Union

from .errors import InputError

__all__ = ["BytesLike", "drive_ids", "number", "octets", "real", "refuse_unordered", "row", "shown", "whole"]

BytesLike = Union[bytes, bytearray, memoryview]
"""Anything that holds bytes."""

# Not in the order of axes or times, or characters in the place of numbers.
_NO_ROWS = (str, bytes, bytearray, Mapping, Set)
# Times, truth values, complex numbers and text: as a list they would be other numbers, or none.
_NO_NUMBERS = "mMbcSU"


def number(value: Any) -> float:
    """A real number of Python or numpy; a ``TypeError``, ``ValueError`` or ``OverflowError`` for anything else, as for a text."""
    if type(value) in (float, int):
        return float(value)
    if isinstance(value, (bool, str, bytes, bytearray)) or _is_no_number(value):
        raise TypeError(f"expected a number, got {shown(value)}")
    return float(value)


def whole(name: str, value: Any, lowest: int, highest: int, error: Type[ValueError] = InputError) -> int:
    """A whole number of Python or numpy within its range."""
    try:
        found: Optional[int] = None if isinstance(value, bool) else operator.index(value)
    except TypeError:
        found = None
    if found is None or not lowest <= found <= highest:
        raise error(f"{name}: expected {lowest} to {highest}, got {shown(value)}")
    return found


def real(name: str, value: Any) -> float:
    """A real number; whether it makes sense is checked where it is used."""
    try:
        return number(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{name}: expected a number, got {shown(value)}") from error


def drive_ids(name: str, drives: Any) -> List[int]:
    """Drive ids in their order."""
    try:
        given = row(drives)
    except TypeError as error:
        raise InputError(f"{name}: expected drive ids: {error}") from error
    return [whole(f"{name}, drive {place}", drive, 1, 63) for place, drive in enumerate(given)]


def octets(name: str, data: BytesLike) -> bytes:
    """The bytes of anything that holds bytes."""
    if isinstance(data, bytes):
        return data
    try:
        view = memoryview(data)
    except TypeError as error:
        raise TypeError(f"{name}: expected bytes, got {shown(data)}") from error
    if view.itemsize != 1:
        raise TypeError(f"{name}: expected bytes, got numbers of {view.itemsize} bytes")
    return view.tobytes()


def _listed(values: Any) -> Any:
    """An array as lists, which are faster to go through; anything else as it is."""
    if _is_no_number(values):
        hint = ": divide by numpy.timedelta64(1, 's')" if values.dtype.kind == "m" else ""
        raise TypeError(f"expected numbers, got an array of {values.dtype}{hint}")
    return values.tolist() if hasattr(values, "tolist") else values


def row(values: Any) -> "Sequence[Any]":
    """Values in an order that is theirs: a list, tuple, array or generator. One number is a row of one."""
    if type(values) in (list, tuple):
        return values  # type: ignore[no-any-return]
    refuse_unordered(values)
    given = _listed(values)
    if isinstance(given, (int, float)):
        return [given]
    if isinstance(given, Iterator):
        return list(given)
    if not isinstance(given, Sequence):
        raise TypeError(f"expected a list, a tuple or an array, got {shown(values)}")
    return given


def refuse_unordered(values: Any) -> None:
    """What can be gone through, but has no order, or other things in it than it seems to."""
    if isinstance(values, _NO_ROWS):
        raise TypeError(f"expected a list, a tuple or an array, got {type(values).__name__} {shown(values)}")


def _is_no_number(value: Any) -> bool:
    """Whether an array or a scalar of numpy holds something else than real numbers."""
    kind = getattr(getattr(value, "dtype", None), "kind", None)
    return kind is not None and kind in _NO_NUMBERS
