"""Exceptions and results travel between processes."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import pytest

import motion_board
from motion_board import BoardError, LogError, Refused, StreamStopped, errors, simulate

ERRORS = (
    LogError("run.log", 3, 21, "expected a number"),
    LogError("run.log", 3, None, "expected a number"),
    Refused("refusal 8: too fast", 8, "Velocity", 1, 2.5, 3.0, "counts per cycle", "give it time", 7),
    Refused("refusal 25: open", 25, None, None, 0.0, 0.0, "", ""),
    StreamStopped("it was stopped", "Stopped", 1.5),
    BoardError("plain"),
)


@pytest.mark.parametrize("error", ERRORS)
def test_an_error_is_the_same_after_pickle_and_copy(error: Exception) -> None:
    for again in (pickle.loads(pickle.dumps(error)), copy.copy(error), copy.deepcopy(error)):
        assert type(again) is type(error) and str(again) == str(error)
        assert vars(again) == vars(error)


def test_a_simulation_is_the_same_after_pickle_and_copy() -> None:
    done = simulate([0.0, 0.1], [[0, 0], [8, -8]])
    for again in (pickle.loads(pickle.dumps(done)), copy.deepcopy(done)):
        assert again == done
        assert again.set_points.shape == done.set_points.shape == (101, 2)


def test_what_the_texts_name_is_there() -> None:
    for name in errors.__all__:
        words = (getattr(errors, name).__doc__ or "").replace("`", " ").split()
        for word in words:
            if word.startswith("motion_board."):
                place: Any = motion_board
                for part in word.rstrip(".,;:").split(".")[1:]:
                    assert part in vars(place) or part in getattr(place, "__annotations__", {}), word
                    place = getattr(place, part, None)
