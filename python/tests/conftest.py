"""What the tests share."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List

import pytest

from motion_board import Board
from motion_board.testing import SimulatedBoard

ROOT = Path(__file__).resolve().parents[2]


def vectors(name: str) -> List[Dict[str, Any]]:
    """Vectors of an independent reference."""
    path = ROOT / "host-tests" / "vectors" / f"{name}.json"
    entries: List[Dict[str, Any]] = json.loads(path.read_text())
    return entries


@pytest.fixture
def simulated() -> Iterator[SimulatedBoard]:
    """A board of two axes."""
    with SimulatedBoard(axes=2) as board:
        yield board


@pytest.fixture
def board(simulated: SimulatedBoard) -> Iterator[Board]:
    """The link to it."""
    with Board.open(simulated.address) as link:
        yield link


@pytest.fixture
def motionctl() -> Callable[..., str]:
    """The tool, whose program MOTIONCTL names: its output, whatever its status."""
    program = os.environ.get("MOTIONCTL")
    if program is None:
        pytest.skip("MOTIONCTL does not name the tool: the package is not compared with it")

    def run(*arguments: str) -> str:
        command = [program, *arguments]
        return subprocess.run(command, stdout=subprocess.PIPE, check=False, text=True, timeout=60).stdout

    return run


