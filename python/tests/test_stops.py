"""What ends a stream ends it, whenever it comes, and nothing else."""

from __future__ import annotations

import os
import sys
import threading
import time
from typing import Any, Callable, Dict, Iterator, List, Tuple

import pytest

from motion_board import Board, ConnectionLost, InputError, Progress, StreamStopped
from motion_board.testing import SimulatedBoard
from test_board import PATIENCE_S, sine, until

Row = Tuple[float, List[float]]


def line(steps: int, each_s: float = 0.1, counts: float = 10.0, base: float = 0.0) -> Iterator[Row]:
    """Along a line, at rest at both ends."""
    for step in range(steps):
        yield each_s * step, [base + counts * step, 0.0]


class Playing:
    """A stream in a thread of its own."""

    def __init__(self, board: Board, points: Any, **how: Any) -> None:
        self.result: Any = None
        self.thread = threading.Thread(target=self._run, args=(board, points, how), daemon=True)
        self.thread.start()

    def _run(self, board: Board, points: Any, how: Dict[str, Any]) -> None:
        try:
            self.result = board.stream(points, **how)
        except Exception as error:
            self.result = error

    def end(self) -> Any:
        """What became of it, in time."""
        self.thread.join(PATIENCE_S)
        assert not self.thread.is_alive(), "the stream never ended"
        return self.result


def stays(simulated: SimulatedBoard) -> bool:
    """Whether nothing moves, for longer than a stream needs to begin."""
    before = simulated.positions()
    time.sleep(0.5)
    return simulated.positions() == before


ENDS: Tuple[Callable[[Board], None], ...] = (Board.stop, Board.halt, Board.disable)


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("delay_s", [0.0, 0.002, 0.05])
def test_what_comes_right_behind_the_beginning_ends_the_stream(
    board: Board, simulated: SimulatedBoard, end: Callable[[Board], None], delay_s: float
) -> None:
    board.enable()
    playing = board.play(list(line(31)))
    next(playing)
    time.sleep(delay_s)
    end(board)
    assert stays(simulated) and not board.snapshot().is_moving
    with pytest.raises(StreamStopped) as stopped:
        for _ in playing:
            pass
    assert stopped.value.phase == "Stopped"
    assert simulated.positions()[0] < 50


def test_a_stop_of_another_thread_right_behind_the_beginning(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()
    begun, stopped = threading.Event(), threading.Event()

    def points() -> Iterator[Row]:
        for point in line(31):
            # For the second set-point it has begun.
            if point[0] > 0.0:
                begun.set()
            yield point

    def stop() -> None:
        begun.wait(PATIENCE_S)
        board.stop()
        stopped.set()

    thread = threading.Thread(target=stop)
    thread.start()
    with pytest.raises(StreamStopped, match="it was stopped"):
        board.stream(points())
    thread.join()
    assert stopped.is_set() and stays(simulated) and simulated.positions()[0] < 50


def test_a_generator_may_stop_its_own_stream(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()

    def points() -> Iterator[Row]:
        yield 0.0, [0.0, 0.0]
        board.stop(5.0)
        yield from ((moment + 0.1, row) for moment, row in line(30))

    with pytest.raises(StreamStopped):
        board.stream(points())
    assert stays(simulated) and simulated.positions() == [0, 0]
    # The next one begins.
    board.stream([0, 0.5], [[0, 0], [10, 10]], relative=True)
    assert simulated.positions() == [10, 10]


def test_a_block_that_is_left_right_behind_the_beginning_moves_nothing(simulated: SimulatedBoard) -> None:
    with Board.open(simulated.address) as board:
        board.enable()
        playing = board.play(list(line(31)))
        next(playing)
    assert stays(simulated) and simulated.positions()[0] < 50


def test_a_stop_does_not_end_what_begins_behind_it(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()
    for turn in range(5):
        playing = board.play(list(line(31)), relative=True)
        next(playing)
        board.stop()
        at = simulated.positions()[0]
        board.stream([0, 0.3], [[0, 0], [10, 0]], relative=True)
        assert simulated.positions()[0] == at + 10, turn


CUTS: Tuple[Callable[[Board, SimulatedBoard], None], ...] = (
    lambda board, simulated: simulated.drop_link(),
    lambda board, simulated: simulated.reset(),
    lambda board, simulated: simulated.close(),
    lambda board, simulated: board.close(),
)


@pytest.mark.filterwarnings("ignore:the stream could not be stopped")
@pytest.mark.parametrize("cut", CUTS, ids=["drop", "reset", "close of the board", "close of the link"])
def test_a_stream_of_which_everything_is_sent_ends_when_the_board_goes(
    board: Board, simulated: SimulatedBoard, cut: Callable[[Board, SimulatedBoard], None]
) -> None:
    board.enable()
    playing = Playing(board, list(line(20, each_s=0.3)))
    until("the motion", lambda: simulated.positions()[0] > 40)
    cut(board, simulated)
    result = playing.end()
    assert isinstance(result, (ConnectionLost, StreamStopped)), result
    board.close()


def test_a_stream_that_was_stopped_leaves_the_next_one_alone(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()
    go_on = threading.Event()

    def slow() -> Iterator[Row]:
        yield from line(5, each_s=0.2)
        go_on.wait(PATIENCE_S)
        # Of a stream that is over: no way of the next one.
        yield 3.5, [60_000.0, 0.0]

    first = Playing(board, slow())
    until("the motion", lambda: simulated.positions()[0] > 5)
    board.stop()
    at = simulated.positions()[0]

    def next_one() -> Iterator[Row]:
        for point in line(31, each_s=0.05, counts=2.0, base=at):
            if point[0] > 0.5:
                go_on.set()
                time.sleep(0.03)
            yield point

    second = Playing(board, next_one())
    assert isinstance(first.end(), StreamStopped)
    assert second.end().set_points == 31
    assert simulated.positions()[0] == at + 60
    assert max(point.positions[0] for point in simulated.trace()) <= at + 61


def test_a_stream_that_is_complete_is_so_when_the_next_one_has_begun(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()
    first = board.play(list(line(5)))
    for step in first:
        if step.sent == 5:
            break
    until("the end", lambda: not board.snapshot().is_moving)
    second = Playing(board, [(0.0, [40.0, 0.0]), (2.0, [80.0, 0.0])])
    until("the next one", lambda: board.snapshot().is_moving)
    with pytest.raises(StopIteration) as end:
        while True:
            next(first)
    assert end.value.value.set_points == 5
    assert second.end().set_points == 2


def test_an_iterator_that_is_closed_behind_its_end_stops_nothing(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()
    first = board.play(list(line(31)))
    next(first)
    board.stop()
    at = float(simulated.positions()[0])
    second = Playing(board, [(0.0, [at, 0.0]), (1.5, [at + 80, 0.0])])
    until("the next one", lambda: simulated.positions()[0] > at + 5)
    first.close()
    assert second.end().set_points == 2


def test_the_first_progress_is_what_was_asked_for(board: Board) -> None:
    board.enable()
    board.stream([0, 0.3], [[0, 0], [10, -10]])
    seen: List[Progress] = []
    board.stream([0, 0.3], [[0, 0], [10, -10]], relative=True, percent=50, progress=seen.append)
    first = seen[0]
    assert (first.phase, first.percent, first.time_s, first.positions) == ("Waiting", 50, 0.0, [10, -10])


@pytest.mark.parametrize("timeout_s", [float("nan"), -1.0, 1e9, "soon"])
def test_what_makes_no_sense_does_nothing_to_a_stream_or_the_drives(
    board: Board, simulated: SimulatedBoard, timeout_s: Any
) -> None:
    board.enable()
    playing = Playing(board, list(line(12)))
    until("the motion", lambda: simulated.positions()[0] > 5)
    # Those that stop do so all the same.
    for call in (board.home, board.enable):
        with pytest.raises((InputError, TypeError)):
            call(timeout_s)
    assert playing.end().set_points == 12
    assert board.snapshot().state == "Enabled"
    with pytest.raises((InputError, TypeError)):
        Board.open("tcp:127.0.0.1:1", timeout_s=timeout_s)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
def test_a_child_that_was_forked_leaves_board_and_link_alone(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()
    child = os.fork()
    if child == 0:
        os._exit(close_in_child(board, simulated))
    deadline = time.monotonic() + PATIENCE_S
    while (ended := os.waitpid(child, os.WNOHANG))[0] == 0 and time.monotonic() < deadline:
        time.sleep(0.01)
    assert ended == (child, 0)
    assert board.snapshot().state == "Enabled"


def close_in_child(board: Board, simulated: SimulatedBoard) -> int:
    """The exit code: 0 when everything went as it should."""
    try:
        with pytest.raises(ConnectionLost, match="another process"):
            board.enable()
        with pytest.raises(ConnectionLost, match="another process"):
            board.snapshot()
        with board:
            pass
        simulated.close()
        return 0
    except BaseException as error:
        print(repr(error), file=sys.stderr, flush=True)
        return 1
