"""Homing over the link: what counts from where, and what ends it."""

import threading
import time

import pytest

from motion_board import Board, BoardError, InputError, Refused
from motion_board.testing import SimulatedBoard


def test_a_homed_axis_counts_from_its_origin_until_it_is_disabled() -> None:
    with SimulatedBoard(axes=2, travel=(-1000, 1000), origins=[5000, None]) as simulated:
        with Board.open(simulated.address) as board:
            board.enable()
            assert [(origin.is_known, origin.is_homed) for origin in board.origins()] == [(False, False), (True, False)]
            with pytest.raises(Refused) as not_homed:
                board.stream([0.0, 0.5], [[0, 0], [100, -100]])
            assert (not_homed.value.number, not_homed.value.axis) == (41, 0)
            board.home()
            assert board.snapshot().state == "Enabled"
            assert [origin.counts for origin in board.origins()] == [5000, 0]
            assert [event.values for event in board.events() if event.kind == "Homed"] == [
                {"axis": 0, "counts": 5000, "uncertainty": 0}
            ]
            board.stream([0.0, 1.0], [[0, 0], [100, -100]])
            assert simulated.positions() == [5100, -100]
            # The travel moves with the origin.
            with pytest.raises(Refused) as beyond:
                board.stream([0.0, 9.0], [[100, -100], [1001, -100]])
            assert (beyond.value.number, beyond.value.axis) == (7, 0)
            board.stream([0.0, 9.0], [[100, -100], [1000, -100]])
            assert simulated.positions() == [6000, -100]
            board.disable()
            board.enable()
            assert not board.origins()[0].is_known


def test_what_cannot_be_homed_says_why() -> None:
    with SimulatedBoard(axes=1) as simulated, Board.open(simulated.address) as board:
        with pytest.raises(Refused) as off:
            board.home()
        assert off.value.number == 24
        board.enable()
        with pytest.raises(Refused) as none:
            board.home()
        assert none.value.number == 42


def test_what_ends_a_homing_is_its_answer() -> None:
    with SimulatedBoard(axes=1, origins=[100]) as simulated, Board.open(simulated.address) as board:
        for end, number in [(board.stop, 43), (board.halt, 43), (simulated.open_stop_circuit, 25)]:
            board.enable()
            thread = threading.Timer(0.1, end)
            thread.start()
            with pytest.raises(Refused) as ended:
                board.home()
            thread.join()
            assert (ended.value.number, ended.value.axis) == (number, 0)
            assert not board.origins()[0].is_known


def test_a_homing_that_takes_too_long_is_stopped() -> None:
    with SimulatedBoard(axes=1, origins=[100]) as simulated, Board.open(simulated.address) as board:
        board.enable()
        with pytest.raises(Exception, match="no reply"):
            board.home(timeout_s=0.05)
        assert board.snapshot().state == "Enabled"
        assert not board.origins()[0].is_known


def test_the_simulated_board_forgets_its_origins_at_a_halt_as_the_boards_do() -> None:
    with SimulatedBoard(axes=1, origins=[100]) as simulated, Board.open(simulated.address) as board:
        board.enable()
        board.home()
        board.halt()
        assert not board.origins()[0].is_known


def test_a_fault_that_ends_a_homing_names_its_axis() -> None:
    with SimulatedBoard(axes=2, origins=[100, None]) as simulated, Board.open(simulated.address) as board:
        board.enable()
        threading.Timer(0.1, lambda: simulated.raise_fault(1, 13, 99)).start()
        with pytest.raises(Refused) as ended:
            board.home()
        assert (ended.value.number, ended.value.axis) == (27, 1)


@pytest.mark.parametrize("timeout_s", [-1.0, float("nan"), float("inf")])
def test_a_time_that_is_none_is_refused_and_nothing_is_homed(timeout_s: float) -> None:
    with SimulatedBoard(axes=1, origins=[100]) as simulated, Board.open(simulated.address) as board:
        board.enable()
        with pytest.raises(InputError, match="timeout_s: expected 0"):
            board.home(timeout_s=timeout_s)
        # The order comes first: a wrong time is no reason to go on.
        with pytest.raises(InputError, match="timeout_s: expected 0"):
            board.stop(timeout_s=timeout_s)
        assert not board.origins()[0].is_known
        # Nothing is enabled by a wrong call, and everything is switched off all the same.
        with pytest.raises(InputError, match="timeout_s: expected 0"):
            board.disable(timeout_s=timeout_s)
        assert board.snapshot().state == "Off"
        with pytest.raises(InputError, match="timeout_s: expected 0"):
            board.enable(timeout_s=timeout_s)
        assert board.snapshot().state == "Off"


def test_an_enable_that_waited_does_not_enable_behind_a_halt() -> None:
    with SimulatedBoard(axes=1, origins=[100]) as simulated, Board.open(simulated.address) as board:
        board.enable()
        ended = []

        def home() -> None:
            with pytest.raises(Refused) as refused:
                board.home()
            ended.append(refused.value.number)

        def enable() -> None:
            # It waits behind the homing, and is given up.
            with pytest.raises(BoardError):
                board.enable()
            ended.append(0)

        threads = [threading.Thread(target=home), threading.Thread(target=enable)]
        threads[0].start()
        time.sleep(0.05)
        threads[1].start()
        time.sleep(0.05)
        board.halt()
        for thread in threads:
            thread.join()
        assert sorted(ended) == [0, 43]
        time.sleep(0.2)
        assert board.snapshot().state == "Halted"


def test_a_simulated_board_has_an_origin_for_each_axis_at_most() -> None:
    with pytest.raises(InputError, match="origins: expected 1 at most"):
        SimulatedBoard(axes=1, origins=[None, 3])
    with pytest.raises(InputError, match="travel: expected the lowest first"):
        SimulatedBoard(axes=1, travel=(5, -5))
