"""The board without a machine, as tests of programs use it."""

from __future__ import annotations

import time
from typing import Any

import pytest

from motion_board import Board, BoardError, InputError, Settings
from motion_board.testing import SimulatedBoard

TEXT = """format = 1
name = "lathe"

[bus]
bit_rate_kbit_per_s = 1000

[[axis]]
drive = 1
gear_number = 4096
speed_rpm = 600
acceleration_rpm_per_s = 10000
travel_min_millidegrees = -3600000
travel_max_millidegrees = 3600000
"""


def opened_again(simulated: SimulatedBoard, boot: int) -> Board:
    """The link to the next start."""
    deadline = time.monotonic() + 20
    while time.monotonic() < deadline:
        try:
            board = Board.open(simulated.address)
        except BoardError:
            continue
        if board.info().boot == boot:
            return board
        board.close()
    raise AssertionError(f"start {boot} never came")


def test_settings_count_from_the_next_start_on_and_are_kept() -> None:
    before, written = Settings(b"before"), Settings.of_text(TEXT)
    with SimulatedBoard(axes=1, settings=before.data) as simulated:
        with Board.open(simulated.address) as board:
            board.write_settings(written)
            assert board.settings == before
        for boot in (2, 3):
            simulated.reset()
            with opened_again(simulated, boot) as board:
                assert board.settings == written


@pytest.mark.parametrize(
    ("options", "text"),
    (
        ({"origins": {0: 500}}, "origins: expected a list"),
        ({"origins": [2**40]}, "origins, axis 0: expected -2147483648 to 2147483647, got 1099511627776"),
        ({"origins": [0.5]}, "origins, axis 0: expected"),
        ({"port": 70000}, "port: expected 0 to 65535, got 70000"),
    ),
)
def test_what_makes_no_board_is_refused(options: Any, text: str) -> None:
    with pytest.raises(InputError) as caught:
        SimulatedBoard(axes=1, **options)
    assert text in str(caught.value)
