"""Set-points as programs give them: what is a row of numbers, and what only looks like one."""

from __future__ import annotations

import datetime
from array import array
from fractions import Fraction
from typing import Any, Dict

import numpy
import pytest

from motion_board import Board, InputError, simulate
from motion_board.testing import SimulatedBoard

ROWS: Dict[str, Any] = {
    "dict": {0: 0, 1: 100},
    "set": {0.0, 100.0},
    "frozenset": frozenset({0.0, 100.0}),
    "str": "09",
    "bytes": b"\0\1",
    "bytearray": bytearray(b"\0\1"),
    "keys": {0: 5, 100: 6}.keys(),
    "texts": ["0", "9"],
    "truths": [False, True],
    "truths of numpy": numpy.array([False, True]),
    "times of numpy": numpy.array([0, 9], "timedelta64[ns]"),
    "dates of numpy": numpy.array([0, 9], "datetime64[ns]"),
    "complex": numpy.array([0j, 9 + 0j]),
    "texts of numpy": numpy.array(["0", "9"]),
    "objects of numpy": numpy.array([numpy.timedelta64(0, "s"), True], dtype=object),
    "columns": type("Columns", (), {"__len__": lambda _: 2, "__iter__": lambda _: iter([0, 9])})(),
}


@pytest.mark.parametrize("row", ROWS.values(), ids=ROWS)
def test_what_is_no_row_moves_nothing(row: Any, board: Board, simulated: SimulatedBoard) -> None:
    start = [0, 0]
    board.enable()
    for points in ([(0, start), (1, row)], iter([(0, start), (1, row)])):
        with pytest.raises(InputError, match="set-point 1"):
            board.stream(points)
    with pytest.raises(InputError, match="set-point 1"):
        board.stream([0, 1], [start, row])
    assert simulated.positions() == [0, 0] and simulated.trace() == []
    with pytest.raises(InputError, match="set-point 1"):
        simulate([0, 1], [start, row])
    with pytest.raises(InputError, match="positions|set-point 0"):
        simulate([0, 1], row)


@pytest.mark.parametrize("row", ROWS.values(), ids=ROWS)
def test_what_is_no_row_is_neither_times_nor_factors(row: Any) -> None:
    with pytest.raises(InputError, match="times|set-point 0|set-point 1: expected a time"):
        simulate(row, [[0], [1]])
    with pytest.raises(InputError, match="counts_per_unit"):
        simulate([0, 1], [[0, 0], [1, 1]], counts_per_unit=row)


def test_the_error_says_where_and_what() -> None:
    nanoseconds = numpy.array([0, 1], "timedelta64[ns]")
    with pytest.raises(InputError) as caught:
        simulate(nanoseconds, [[0], [1]])
    assert str(caught.value) == (
        "times: expected numbers, got an array of timedelta64[ns]: divide by numpy.timedelta64(1, 's')"
    )
    for value, text in (
        ("5", "set-point 1, axis 1: expected a position, got '5'"),
        (10**400, "set-point 1, axis 1: expected a position, got 1000000"),
        (numpy.True_, "set-point 1, axis 1: expected a position, got"),
        (1j, "set-point 1, axis 1: expected a position, got 1j"),
    ):
        with pytest.raises(InputError) as caught:
            simulate([(0, [0, 0]), (1, [0, value])])
        assert text in str(caught.value)
    for time in ("1", True, datetime.timedelta(seconds=1), numpy.timedelta64(1, "ns"), 10**400):
        with pytest.raises(InputError, match="set-point 1: expected a time in seconds, got"):
            simulate([(0, [0]), (time, [1])])


@pytest.mark.parametrize("points", ({(0, (0,)): 1, (1, (5,)): 2}, {(0, (0,)), (1, (5,))}, "01", b"01", 5, None))
def test_what_has_no_order_is_no_list_of_set_points(points: Any) -> None:
    with pytest.raises(InputError, match="pairs of a time and a row"):
        simulate(points)


@pytest.mark.parametrize("point", ("01", b"\0\1", {0: 1, 1: 2}, {1, 0}, 5, None, (0, [0], 1)))
def test_what_is_no_pair_is_no_set_point(point: Any) -> None:
    with pytest.raises(InputError, match="set-point 0: expected a time and a row"):
        simulate([point])


@pytest.mark.parametrize(
    "rows",
    (
        [[0.0, 0.0], [8.0, -8.0]],
        ((0, 0), (8, -8)),
        numpy.array([[0, 0], [8, -8]]),
        numpy.array([[0, 0], [8, -8]], dtype=object),
        [numpy.zeros(2), numpy.array([8, -8], numpy.int8)],
        [array("d", [0, 0]), array("h", [8, -8])],
        [[0, 0], [Fraction(8), numpy.float32(-8)]],
        [iter([0, 0]), (at for at in (8, -8))],
        memoryview(array("q", [0, 0, 8, -8]).tobytes()).cast("q", (2, 2)),
    ),
)
def test_sequences_arrays_and_generators_are_rows(rows: Any) -> None:
    assert [axis.target_counts for axis in simulate([0.0, 0.1], rows).axes] == [8, -8]


@pytest.mark.parametrize(
    "factor", (2, 2.0, Fraction(2), numpy.int64(2), numpy.float32(2), numpy.float64(2), numpy.array(2), [2, 2], numpy.array([2, 2]))
)
def test_a_factor_of_any_kind_of_number_counts_for_all_axes(factor: Any) -> None:
    done = simulate([0.0, 0.1], [[0, 0], [8, -8]], counts_per_unit=factor)
    assert [axis.target_counts for axis in done.axes] == [16, -16]


def test_an_array_alone_is_checked_before_anything_is_sent(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()
    with pytest.raises(InputError, match="set-point 2: expected a time after"):
        board.play(numpy.array([(0, [0, 0]), (1, [5, 5]), (0.5, [6, 6])], dtype=object))
    assert simulated.trace() == []
