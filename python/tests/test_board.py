"""The link, against a board of which only the axes are simulated."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
import threading
import time
from typing import Any, Dict, Iterator, List, Tuple

import numpy
import pytest

from motion_board import (
    Board,
    BoardError,
    CodecError,
    ConnectionLost,
    Fault,
    InputError,
    NotConnected,
    Progress,
    Refused,
    Settings,
    StreamStopped,
)
from motion_board.testing import SimulatedBoard

PATIENCE_S = 20.0


def until(what: str, holds: Any) -> None:
    """Waits until something is so."""
    deadline = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < deadline, f"{what} never came"
        time.sleep(0.005)


def check_limits(simulated: SimulatedBoard, velocity: float = 100.0, acceleration: float = 1.5) -> None:
    """What went out kept the limits, from rest to rest."""
    rows = numpy.array([point.positions for point in simulated.trace()])
    rows = numpy.vstack([rows[:1], rows[:1], rows, rows[-1:], rows[-1:]])
    assert numpy.abs(numpy.diff(rows, axis=0)).max() <= velocity * 1.0001
    assert numpy.abs(numpy.diff(rows, n=2, axis=0)).max() <= acceleration * 1.0001


def sine(seconds: float, counts: float = 2000.0, rate: float = 50.0) -> Tuple[Any, Any]:
    """Two axes, from rest to rest."""
    times = numpy.arange(0.0, seconds + 0.5 / rate, 1.0 / rate)
    swing = counts * numpy.sin(numpy.pi * times / seconds) ** 2
    return times, numpy.column_stack([swing, -0.5 * swing])


def test_a_board_says_what_it_is_and_nothing_is_enabled(board: Board, simulated: SimulatedBoard) -> None:
    info = board.info()
    assert (info.board, info.axes, info.cycle_us, info.boot) == ("simulated", 2, 1000, 1)
    snapshot = board.snapshot()
    assert (snapshot.state, snapshot.phase, snapshot.targets) == ("Off", "Idle", [0, 0])
    assert not snapshot.is_moving and board.axes == 2
    assert simulated.trace() == []


def test_arrays_are_played_to_their_end_within_the_limits(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()
    seen: List[Progress] = []
    times, rows = sine(1.5)
    result = board.stream(times, rows, progress=seen.append)
    assert result.set_points == len(times) and result.time_s == pytest.approx(1.5)
    assert simulated.positions() == [0, 0]
    trace = simulated.trace()
    assert len(trace) >= 1500
    check_limits(simulated)
    played = numpy.array([point.positions for point in trace])
    assert played[:, 0].max() == pytest.approx(2000, abs=1) and played[:, 1].min() == pytest.approx(-1000, abs=1)
    # Every set-point that was sent went out in its cycle.
    for moment, row in zip(times[:-1], rows):
        at = played[round(moment * 1000)]
        assert numpy.abs(at - row).max() < 1e-3, moment
    assert any(step.phase == "Moving" and step.positions != [0, 0] for step in seen)
    assert seen[-1].sent == len(times)
    kinds = [event.kind for event in board.events()]
    assert kinds.count("State") == 1 and "Stream" in kinds
    assert [event.values["phase"] for event in Board.events(board)] == []


def test_what_was_sent_is_every_set_point_at_its_time(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()
    board.stream([0.0, 0.25, 0.5, 1.0], [[0, 0], [300, 10], [700, -20], [1000, 30]])
    board.stream([0.0, 0.5], [[0, 0], [1, -1]], relative=True, counts_per_unit=[100, 16.0])
    assert simulated.positions() == [1100, 14]
    assert board.snapshot().targets == [1100, 14]


def test_a_generator_is_taken_as_the_board_has_room(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()
    taken: List[float] = []

    def points() -> Iterator[Tuple[float, List[float]]]:
        for step in range(301):
            taken.append(time.monotonic())
            yield 0.01 * step, [5.0 * step * min(step, 300 - step) / 150, 0.0]

    board.stream(points())
    # 64 segments on the board and 96 on their way are 1.6 s of 3 s.
    assert taken[-1] - taken[0] > 0.5
    assert simulated.positions() == [0, 0]
    check_limits(simulated)


def test_the_steps_of_a_stream_can_be_looked_at(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()
    times, rows = sine(1.0)
    steps = list(board.play(times, rows))
    assert steps[-1].sent == len(times) and all(a.time_s <= b.time_s for a, b in zip(steps, steps[1:]))
    simulated.trace(clear=True)
    playing = board.play(*sine(4.0))
    for step in playing:
        if step.time_s > 0.8:
            break
    playing.close()
    assert not board.snapshot().is_moving
    assert 0 < simulated.positions()[0] < 2000
    check_limits(simulated)


WRONG: Tuple[Tuple[Any, Any, str], ...] = (
    ([0, 1], [[0, 0]], "as many rows of positions as times: got 2 times and 1 rows"),
    ([0, 1], [[0, 0], [1]], "set-point 1: expected 2 positions, one for each axis, got 1"),
    ([0, 1], [[0, 0, 0], [1, 1, 1]], "set-point 0: expected 2 positions, one for each axis, got 3"),
    ([0, 1], numpy.array([[0, 0], [numpy.nan, 0]]), "set-point 1, axis 0: expected a position, got nan"),
    ([0, 1, 0.5], [[0, 0], [1, 1], [2, 2]], "set-point 2: expected a time after 1.0 s, got 0.5 s"),
    (numpy.array([0, numpy.inf]), [[0, 0], [1, 1]], "set-point 1: expected a time in seconds, got inf"),
    (numpy.zeros((2, 2)), [[0, 0], [1, 1]], "set-point 0: expected a time in seconds, got [0.0, 0.0]"),
    ([], [], "at least one set-point"),
    ([(0, [0, 0]), "end"], None, "set-point 1: expected a time and a row of positions, got 'end'"),
)


@pytest.mark.parametrize(("times", "rows", "text"), WRONG)
def test_what_makes_no_sense_is_refused_before_anything_is_sent(
    board: Board, simulated: SimulatedBoard, times: Any, rows: Any, text: str
) -> None:
    board.enable()
    board.events()
    with pytest.raises(InputError) as caught:
        board.stream(times, rows)
    assert text in str(caught.value)
    assert board.counters().segments == 0 and board.counters().refused == 0
    assert board.snapshot().phase == "Idle" and simulated.trace() == []
    with pytest.raises(InputError, match="percent"):
        board.stream([0, 1], [[0, 0], [1, 1]], percent=201)
    with pytest.raises(InputError, match="when_dry"):
        board.stream([0, 1], [[0, 0], [1, 1]], when_dry="go on")
    with pytest.raises(InputError, match="counts_per_unit: expected one for each of 2 axes, got 3"):
        board.stream([0, 1], [[0, 0], [1, 1]], counts_per_unit=[1, 2, 3])


def test_a_generator_that_goes_wrong_stops_along_the_path(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()

    def points(last: Any) -> Iterator[Tuple[float, List[float]]]:
        for step in range(200):
            yield 0.02 * step, [10.0 * step * step / (step + 10), 0.0]
        yield last

    with pytest.raises(InputError, match="set-point 200, axis 1: expected a position, got nan"):
        board.stream(points((9.0, [0.0, float("nan")])))
    assert not board.snapshot().is_moving and simulated.positions()[0] > 0
    check_limits(simulated)

    def failing() -> Iterator[Tuple[float, List[float]]]:
        yield 0.0, [float(at) for at in simulated.positions()]
        raise KeyError("the sensor is gone")

    with pytest.raises(KeyError, match="sensor"):
        board.stream(failing())


def test_a_refusal_has_number_axis_values_and_advice(board: Board, simulated: SimulatedBoard) -> None:
    with pytest.raises(Refused) as caught:
        board.stream([0, 1], [[0, 0], [10, 10]])
    refused = caught.value
    assert (refused.number, refused.reason, refused.axis) == (24, "NotEnabled", None)
    assert "enable" in refused.advice and refused.index is None
    board.enable()
    with pytest.raises(Refused) as caught:
        board.stream([0, 1], [[5, 0], [10, 10]])
    refused = caught.value
    assert (refused.number, refused.axis, refused.expected, refused.actual, refused.unit) == (2, 0, 0.0, 5.0, "counts")
    times, rows = sine(1.0)
    rows[30:, 1] += 60_000
    with pytest.raises(Refused) as caught:
        board.stream(times, rows)
    refused = caught.value
    assert refused.reason in ("Velocity", "Acceleration") and refused.axis == 1
    assert refused.index in (29, 30) and refused.actual > refused.expected
    assert str(refused).startswith(f"set-point {refused.index}: refusal {refused.number}: axis 1: ")
    assert not board.snapshot().is_moving
    check_limits(simulated)


def test_the_inputs_rule_and_faults_are_kept(board: Board, simulated: SimulatedBoard) -> None:
    simulated.open_stop_circuit()
    until("the open stop circuit", lambda: board.snapshot().state == "StopOpen")
    with pytest.raises(Refused) as caught:
        board.enable()
    assert caught.value.reason == "StopInput" and "close it" in caught.value.advice
    simulated.close_stop_circuit()
    until("the closed stop circuit", lambda: board.snapshot().state == "Off")
    board.enable()

    def fails(step: Progress) -> None:
        if step.phase == "Moving":
            simulated.raise_fault(1, 7, detail=-3)

    with pytest.raises(StreamStopped) as stopped:
        board.stream(*sine(3.0), progress=fails)
    assert stopped.value.phase == "Stopped" and stopped.value.time_s < 3.0
    assert "Faulted, axis 1 has fault 7" in str(stopped.value)
    [fault] = board.faults()
    assert (fault.number, fault.boot, fault.axis, fault.code, fault.detail) == (1, 1, 1, 7, -3)
    assert fault.text.startswith("the configuration of the drive cannot be used")
    assert any(event.kind == "Fault" and event.values["code"] == 7 for event in board.events())
    with pytest.raises(Refused, match="axis 1"):
        board.enable()
    board.clear()
    board.enable()


def test_another_thread_stops_a_stream(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()

    def stop() -> None:
        until("the motion", lambda: simulated.positions()[0] > 100)
        board.stop()

    thread = threading.Thread(target=stop)
    thread.start()
    with pytest.raises(StreamStopped) as stopped:
        board.stream(*sine(5.0))
    thread.join()
    assert stopped.value.phase == "Stopped"
    assert 100 < simulated.positions()[0] < 2000
    check_limits(simulated)
    # The next one begins where they stand.
    board.stream([0, 0.5], [[0, 0], [10, 10]], relative=True)


def test_set_points_that_come_too_late_end_along_the_path(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()

    def points() -> Iterator[Tuple[float, List[float]]]:
        for step in range(60):
            if step == 40:
                time.sleep(1.5)
            yield 0.02 * step, [20.0 * step, 0.0]

    with pytest.raises(StreamStopped) as stopped:
        board.stream(points(), relative=True)
    assert stopped.value.phase == "DriedUp" and "came too late" in str(stopped.value)
    check_limits(simulated)
    board.stream(points(), relative=True, when_dry="wait")
    check_limits(simulated)


def test_pause_override_and_halt(board: Board, simulated: SimulatedBoard) -> None:
    board.enable()
    begin = time.monotonic()
    board.stream(*sine(1.0), percent=50)
    assert time.monotonic() - begin > 1.9
    with pytest.raises(InputError, match="0 to 200"):
        board.set_override(201)
    playing = board.play(*sine(2.0))
    next(step for step in playing if step.time_s > 0.5)
    board.pause()
    until("the pause", lambda: board.snapshot().percent == 0)
    assert board.snapshot().phase == "Moving"
    board.set_override(200)
    board.resume()
    for _ in playing:
        pass
    assert simulated.positions() == [0, 0]
    check_limits(simulated)
    playing = board.play(*sine(2.0))
    next(step for step in playing if step.time_s > 0.5)
    board.halt()
    with pytest.raises(StreamStopped, match="it was stopped"):
        for _ in playing:
            pass
    assert board.snapshot().state == "Halted"
    board.stop()
    with pytest.raises(Refused) as refused:
        board.stream(*sine(1.0))
    assert refused.value.reason == "NotEnabled"
    with pytest.raises(Refused) as refused:
        board.write_settings(board.settings)
    assert refused.value.reason == "Enabled"
    board.enable()
    board.stream(*sine(1.0), relative=True)
    board.halt()
    board.disable()
    assert board.snapshot().state == "Off"


def test_one_program_commands_and_others_read() -> None:
    # The simulated board has one port, as a cable has one end: the second program comes when the first one is gone.
    with SimulatedBoard(axes=1, silence_cycles=3000) as simulated:
        first = Board.open(simulated.address)
        first.enable()
        simulated.drop_link()
        with pytest.raises(BoardError):
            for _ in range(1000):
                first.snapshot()
        with pytest.raises(NotConnected, match="another session commands"):
            Board.open(simulated.address, timeout_s=0.5)
        reader = Board.open(simulated.address, commands=False)
        assert reader.snapshot().state == "Enabled"
        with pytest.raises(Refused) as caught:
            reader.disable()
        assert caught.value.reason in ("Taken", "NoSession")
        reader.close()
        first.close()


def test_a_block_ends_with_everything_off(simulated: SimulatedBoard) -> None:
    with Board.open(simulated.address) as board:
        board.enable()
        playing = board.play(*sine(4.0))
        next(step for step in playing if step.time_s > 0.3)
        del playing
    check_limits(simulated)
    with pytest.raises(ZeroDivisionError):
        with Board.open(simulated.address) as board:
            assert board.snapshot().state == "Off"
            board.enable()
            raise ZeroDivisionError
    with Board.open(simulated.address, commands=False) as reader:
        assert reader.snapshot().state == "Off"
    with pytest.raises(ConnectionLost, match="the link is closed"):
        reader.info()


def test_a_reset_board_and_a_pulled_cable_are_noticed(simulated: SimulatedBoard) -> None:
    with Board.open(simulated.address) as board:
        board.enable()

        def resets(step: Progress) -> None:
            if step.time_s > 0.2:
                simulated.reset()

        with pytest.raises((ConnectionLost, StreamStopped)):
            board.stream(*sine(3.0), progress=resets)
        until("the new start", lambda: board.info().boot > 1)
        assert board.snapshot().state == "Off"
        simulated.drop_link()
        with pytest.raises(ConnectionLost, match="port is gone"):
            for _ in range(100):
                board.snapshot()
        with pytest.warns(RuntimeWarning, match="the drives may be on"):
            raise_in_block(board)


def raise_in_block(board: Board) -> None:
    with pytest.raises(KeyError):
        with board:
            raise KeyError("the error of the block is the one to see")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_a_pseudo_terminal_is_a_serial_port(simulated: SimulatedBoard) -> None:
    import os
    import select
    import socket
    import tty

    near, far = os.openpty()
    tty.setraw(far)
    cable = socket.create_connection(("127.0.0.1", int(simulated.address.rsplit(":", 1)[1])))
    ends: List[Any] = [near, cable]
    is_cut = threading.Event()

    def relay() -> None:
        while not is_cut.is_set():
            ready, _, _ = select.select(ends, [], [], 0.02)
            if cable in ready:
                os.write(near, cable.recv(4096))
            if near in ready:
                cable.sendall(os.read(near, 4096))

    thread = threading.Thread(target=relay)
    thread.start()
    try:
        with Board.open(os.ttyname(far)) as board:
            assert board.info().board == "simulated"
            board.enable()
            board.stream(*sine(1.0))
            lost = board.counters().losses
            assert sum(lost.values()) == 0
        board = Board.open(os.ttyname(far), commands=False)
    finally:
        is_cut.set()
        thread.join()
    os.close(far)
    os.close(near)
    cable.close()
    with pytest.raises(ConnectionLost, match="port is gone"):
        for _ in range(100):
            board.snapshot()
    board.close()
    # It computes: before, it would have kept the cable waiting for the interpreter.
    check_limits(simulated)


def test_where_no_board_is() -> None:
    with pytest.raises(NotConnected, match="cannot open /dev/no-such-port"):
        Board.open("/dev/no-such-port")
    with pytest.raises(NotConnected, match="cannot connect to tcp:1"):
        Board.open("tcp:1")
    with pytest.raises(NotConnected, match="an address of this machine, got tcp:192.0.2.1:7000"):
        Board.open("tcp:192.0.2.1:7000")
    import socket

    with socket.create_server(("127.0.0.1", 0)) as silent:
        with pytest.raises(NotConnected, match="no board has answered in 0.3 s"):
            Board.open(f"tcp:{silent.getsockname()[1]}", timeout_s=0.3)


SETTINGS = """
format = 1
name = "lathe"

[bus]
bit_rate_kbit_per_s = 1000
"""
AXIS = """
[[axis]]
drive = {drive}
gear_number = {gear}
speed_rpm = 600
acceleration_rpm_per_s = 10000
travel_min_millidegrees = -3600000
travel_max_millidegrees = 3600000
"""


def test_settings_are_written_and_read_whole(board: Board, simulated: SimulatedBoard) -> None:
    assert board.settings.data == b""
    with pytest.raises(CodecError):
        board.settings.text
    text = SETTINGS + "".join(AXIS.format(drive=drive, gear=4096 // (1 + drive % 2)) for drive in range(1, 13))
    settings = Settings.of_text(text)
    assert len(settings.data) > 256
    board.write_settings(settings)
    # They count from the next start on.
    assert board.settings.data == b""
    assert Settings.of_text(settings.text) == settings
    values = settings.values
    assert (values["name"], values["bus"]["bit_rate_kbit_per_s"], len(values["axes"])) == ("lathe", 1000, 12)
    assert values["axes"][1]["drive"] == 2 and values["axes"][1]["speed_rpm"] == 600
    assert settings.counts_per_turn[1] == 16384 and settings.counts_per_turn[0] != 16384
    board.enable()
    with pytest.raises(Refused) as caught:
        board.write_settings(settings)
    assert caught.value.reason == "Enabled"
    for wrong, place in ((SETTINGS + "\nspeed = 1", "line 8, column 1:"), (SETTINGS.replace("1000", '"fast"'), "line 6, column")):
        with pytest.raises(CodecError) as error:
            Settings.of_text(wrong)
        assert place in str(error.value)


def test_fourteen_axes_at_the_limit_of_a_jerk() -> None:
    with SimulatedBoard(axes=14, acceleration=1.0, jerk=0.05) as simulated, Board.open(simulated.address) as board:
        board.enable()
        times = numpy.arange(0, 1.51, 0.02)
        swing = 500 * numpy.sin(numpy.pi * times / 1.5) ** 4
        board.stream(times, swing[:, None] * numpy.linspace(-1, 1, 14))
        rows = numpy.array([point.positions for point in simulated.trace()])
        assert numpy.abs(numpy.diff(rows, n=3, axis=0)).max() <= 0.05 * 1.0001
        assert simulated.positions() == [0] * 14


PROGRAM = """
    import sys, time, motion_board
    with motion_board.Board.open(sys.argv[1]) as board:
        board.enable()
        print("moving", flush=True)
        board.stream(((0.02 * step, [5.0 * step, 0.0]) for step in range(10**9)))
"""


def run_until_it_moves(simulated: SimulatedBoard) -> "subprocess.Popen[str]":
    command = [sys.executable, "-c", textwrap.dedent(PROGRAM), simulated.address]
    program = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    until("the motion", lambda: simulated.positions()[0] > 300)
    return program


def test_ctrl_c_stops_along_the_path_and_disables(simulated: SimulatedBoard) -> None:
    program = run_until_it_moves(simulated)
    program.send_signal(signal.SIGINT)
    _, errors = program.communicate(timeout=PATIENCE_S)
    assert "KeyboardInterrupt" in errors and "Warning" not in errors
    check_limits(simulated)
    with Board.open(simulated.address) as board:
        assert board.snapshot().state == "Off"


def test_a_program_that_dies_is_a_stop_along_the_path(simulated: SimulatedBoard) -> None:
    program = run_until_it_moves(simulated)
    program.kill()
    program.communicate(timeout=PATIENCE_S)
    with Board.open(simulated.address, commands=False) as board:
        until("the stop", lambda: not board.snapshot().is_moving)
        assert board.snapshot().phase in ("Stopped", "DriedUp")
        assert board.counters().silent_hosts == 1
    check_limits(simulated)


class GrowingLog:
    """A link whose fault log gets an entry between two questions."""

    def __init__(self) -> None:
        self.numbers = [3, 2, 1]
        self.asked = 0

    def fault(self, index: int) -> Dict[str, Any]:
        self.asked += 1
        if self.asked == 2:
            self.numbers.insert(0, 4)
        if index >= len(self.numbers):
            raise Refused("no entry", 35, "NoEntry", None, 0.0, 0.0, "", "", None)
        names = ("boot", "uptime_ms", "firmware", "axis", "code", "detail", "place")
        return {"number": self.numbers[index], **dict.fromkeys(names, 0)}


def test_a_fault_between_two_entries_is_no_entry_twice() -> None:
    link: Any = GrowingLog()
    entries: List[Fault] = Board(link, commands=False).faults()
    assert [entry.number for entry in entries] == [3, 2, 1]
