"""The examples run to their end and move what they say."""

from __future__ import annotations

import importlib.util
import os
import struct
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import ModuleType
from typing import Any, Iterator, List

import numpy
import pytest

from motion_board import Board
from motion_board.testing import SimulatedBoard

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def run(name: str, *arguments: str) -> str:
    command = [sys.executable, str(EXAMPLES / name), *arguments]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, text=True, timeout=60)
    assert done.returncode == 0, done.stdout
    return done.stdout


def module(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert spec is not None and spec.loader is not None
    loaded = importlib.util.module_from_spec(spec)
    sys.modules[name] = loaded
    spec.loader.exec_module(loaded)
    return loaded


def is_off(simulated: SimulatedBoard) -> bool:
    with Board.open(simulated.address, commands=False) as reader:
        return reader.snapshot().state == "Off"


def test_the_sine_swings_both_axes(simulated: SimulatedBoard) -> None:
    said = run("sine.py", simulated.address, "--seconds", "4")
    assert "201 set-points in 4.0 s" in said
    rows = numpy.array([point.positions for point in simulated.trace()])
    # A quarter of a period after the ramp the first axis is at its end, a half the second one.
    assert rows[1000] == pytest.approx([500, 0], abs=1) and rows[2000] == pytest.approx([0, -500], abs=1)
    assert is_off(simulated)


def test_arrays_are_simulated_and_played(simulated: SimulatedBoard) -> None:
    said = run("arrays.py", simulated.address)
    assert "the bus carries the axes: True" in said
    assert "0 late, every promise kept: True" in said and "played: 121 set-points in 3.0 s" in said
    rows = numpy.array([point.positions for point in simulated.trace()])
    assert rows[1500] == pytest.approx([8192, -8192], abs=1)
    assert is_off(simulated)
    assert "played" not in run("arrays.py")


def test_a_fake_gamepad_moves_the_axes(simulated: SimulatedBoard) -> None:
    gamepad = module("gamepad")

    def sticks() -> Iterator[Any]:
        yield from [gamepad.Stick(1.0, 0.0, False)] * 50
        yield from [gamepad.Stick(0.1, -0.1, False)] * 25
        yield gamepad.Stick(0.0, -1.0, False)
        yield gamepad.Stick(0.0, -1.0, True)

    with Board.open(simulated.address) as board:
        board.enable()
        gamepad.drive(board, sticks(), 2000.0, 4000.0)
    rows = numpy.array([point.positions for point in simulated.trace()])
    assert rows[-1, 0] == pytest.approx(2000 * 1.0 - 20, abs=25) and -10 < rows[-1, 1] < 0
    speeds = numpy.diff(rows[:, 0]) * 1000
    assert speeds.max() == pytest.approx(2000, rel=0.02) and speeds.min() > -50


def test_what_a_gamepad_says_is_never_faster_than_allowed() -> None:
    gamepad = module("gamepad")
    values = [2.0, -2.0, float("nan"), 0.2, -0.9, 1.0] * 20
    sticks = [gamepad.Stick(x, y, False) for x, y in zip(values, values[1:])]
    points = list(gamepad.set_points(sticks, 1000.0, 3000.0, wait=lambda moment: None))
    rows = numpy.array([row for _, row in points])
    assert numpy.isfinite(rows).all()
    assert numpy.abs(numpy.diff(rows, axis=0)).max() <= 1000 / 50 + 1e-6
    assert numpy.abs(numpy.diff(rows, n=2, axis=0)).max() <= 3000 / 50**2 + 1e-6
    assert (rows[-1] == rows[-2]).all()


def test_events_of_a_joystick_are_read(tmp_path: Path) -> None:
    gamepad = module("gamepad")
    fifo = tmp_path / "js0"
    os.mkfifo(fifo)
    event = struct.Struct("IhBB")
    seen: List[Any] = []
    writer: List[int] = []

    def opens() -> None:
        writer.append(os.open(fifo, os.O_WRONLY))

    thread = threading.Thread(target=opens)
    thread.start()
    time.sleep(0.05)
    sticks = gamepad.joystick(str(fifo))
    thread_has_opened = False
    for stick in sticks:
        seen.append(stick)
        thread.join()
        if not thread_has_opened:
            thread_has_opened = True
            data = event.pack(1, 32767, 0x82, 0) + event.pack(2, -32767, 0x02, 1) + event.pack(3, 9, 0x02, 5)
            os.write(writer[0], data)
        elif len(seen) == 2:
            os.write(writer[0], event.pack(4, 1, 0x01, 0))
        elif len(seen) == 3:
            os.close(writer[0])
        if len(seen) > 50:
            break
    assert seen[1] == (1.0, -1.0, False) and seen[2] == (1.0, -1.0, True)
    assert len(seen) == 3
