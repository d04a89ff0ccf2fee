"""A motion on simulated drives."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
import textwrap
import time
from typing import Any, Dict, List

import numpy
import pytest

from motion_board import InputError, plan, simulate


def quintic(times: List[float], rows: "numpy.ndarray[Any, Any]", moment: float) -> "numpy.ndarray[Any, Any]":
    """The curve by its definition: through the points, with slope and curvature of the parabola through three of them."""
    last = len(times) - 1
    place = min(max(0, int(numpy.searchsorted(times, moment, "right")) - 1), last - 1)

    def slopes(at: int) -> List[Any]:
        if at in (0, last):
            return [numpy.zeros(rows.shape[1])] * 2
        parabola = numpy.polyfit(numpy.array(times[at - 1 : at + 2]) - times[at], rows[at - 1 : at + 2], 2)
        return [parabola[1], 2 * parabola[0]]

    length = times[place + 1] - times[place]
    powers = numpy.vander([0.0, length], 6, increasing=True)
    first = numpy.array([[n * t ** (n - 1) if n else 0.0 for n in range(6)] for t in (0.0, length)])
    second = numpy.array([[n * (n - 1) * t ** (n - 2) if n > 1 else 0.0 for n in range(6)] for t in (0.0, length)])
    left, right = slopes(place), slopes(place + 1)
    wanted = [rows[place], rows[place + 1], left[0], right[0], left[1], right[1]]
    factors = numpy.linalg.solve(numpy.vstack([powers, first, second]), numpy.array(wanted))
    return numpy.array([(moment - times[place]) ** n for n in range(6)]) @ factors


def test_set_points_follow_the_curve_and_motors_arrive() -> None:
    times = [0.0, 0.3, 0.5, 0.9, 1.4]
    rows = numpy.array([[0, 100], [900, -200], [1700, -500], [2500, 300], [2400, 0]])
    done = simulate(numpy.array(times), rows)
    assert done.promises_kept and done.late_cycles == 0 and done.faults == 0
    assert [axis.received_counts for axis in done.axes] == [2400, -100]
    table = numpy.asarray(done.set_points)
    assert table.shape == (done.cycles, 2) == (1401, 2)
    for cycle in range(0, done.cycles, 7):
        expected = quintic(times, rows, cycle / 1000)
        assert numpy.abs(table[cycle] - expected).max() <= 0.51, cycle
    motors = numpy.asarray(done.positions)
    assert numpy.abs(motors - table).max() < 500 and numpy.abs(motors[-1] - table[-1]).max() < 60


def test_lists_and_generators_are_taken_as_arrays_are() -> None:
    times = [0.02 * step for step in range(51)]
    rows = [[math.sin(math.pi * time) ** 2 * 0.1] for time in times]
    whole = simulate(times, rows, counts_per_unit=16384, drives=[7])
    piecewise = simulate(zip(times, rows), counts_per_unit=[16384])
    assert whole.set_points.tolist() == piecewise.set_points.tolist()
    assert numpy.asarray(whole.set_points).max() == 1638
    assert whole.axes[0].drive == 7 and whole.times()[-1] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("times", "rows", "options", "text"),
    (
        ([0, 1], [[0], [1], [2]], {}, "as many rows of positions as times: got 2 times and 3 rows"),
        ([0, 1], [[0], [1, 2]], {}, "set-point 1: expected 1 positions"),
        ([0, 1], [[0], [float("nan")]], {}, "set-point 1, axis 0: expected a position, got nan"),
        ([0, 1, 1], [[0], [1], [2]], {}, "set-point 2: expected a time after 1.0 s, got 1.0 s"),
        ([0, float("inf")], [[0], [1]], {}, "set-point 1: expected a time in seconds, got inf"),
        ([], [], {}, "at least one set-point"),
        ([0, 1], [[0], ["far"]], {}, "set-point 1, axis 0: expected a position, got 'far'"),
        ([0, 1], [[0], [1]], {"drives": [1, 2]}, "expected 2 positions, one for each drive, got 1"),
        ([0, 1], [[0], [1]], {"counts_per_unit": [1, 2]}, "counts_per_unit: expected one for each of 1 axes, got 2"),
        ([0, 1], [[0], [1]], {"counts_per_unit": 0.0}, "counts_per_unit, axis 0: expected a number other than 0"),
        ([0, 0.1, 0.2], [[0], [20000], [0]], {}, "set-point 1: refusal 8: axis 0: too fast: expected 136.5"),
        ([0, 1], [[0], [1]], {"bit_rate_kbit": 123}, "bit_rate_kbit"),
        ([0, 1], [[0], [1]], {"max_rpm": -1}, "limits"),
        ([0, 1], [[0], [1]], {"cycle_us": 0}, "cycle_us"),
        ([0, 1], [[0], [1e12]], {}, "2^31 counts"),
        ([0, 1], [[0], [1]], {"cycle_us": 1000.5}, "cycle_us: expected 250 to 1000000, got 1000.5"),
        ([0, 1], [[0], [1]], {"cycle_us": None}, "cycle_us: expected 250 to 1000000, got None"),
        ([0, 1], [[0], [1]], {"seed": -1}, "seed: expected 0 to 18446744073709551615, got -1"),
        ([0, 1], [[0], [1]], {"seed": True}, "seed: expected 0 to"),
        ([0, 1], [[0], [1]], {"max_rpm": "fast"}, "max_rpm: expected a number, got 'fast'"),
        ([0, 1], [[0], [1]], {"max_jerk": 10**400}, "max_jerk: expected a number, got 1000"),
        ([0, 1], [[0], [1]], {"drives": {3}}, "drives: expected drive ids: expected a list"),
        ([0, 1], [[0], [1]], {"drives": [2**40]}, "drives, drive 0: expected 1 to 63, got 1099511627776"),
    ),
)
def test_a_motion_that_cannot_be_played_is_refused(times: Any, rows: Any, options: Dict[str, Any], text: str) -> None:
    with pytest.raises(InputError) as caught:
        simulate(times, rows, **options)
    assert text in str(caught.value)


def test_a_bus_that_does_not_carry_its_axes_is_refused() -> None:
    with pytest.raises(InputError, match="does not fit"):
        simulate([0, 1], [[0] * 14, [0] * 14])


def test_one_set_point_is_a_motion_of_one_cycle() -> None:
    done = simulate([3.0], [[5, -5]])
    for table in (done.set_points, done.positions):
        assert numpy.asarray(table).tolist() == [[5, -5]]
    assert done.promises_kept and done.cycles == 1 and done.times() == [0.0]


@pytest.mark.parametrize("start", (-1.0, 5.0, 1.7e9))
def test_the_first_time_is_the_start(start: float) -> None:
    done = simulate([start, start + 0.25], [[0], [40]])
    assert done.set_points.tolist() == simulate([0.0, 0.25], [[0], [40]]).set_points.tolist()


@pytest.mark.parametrize("cycle_us", (500, 10_000, 10_001, 20_000, 100_000, 500_000))
def test_every_cycle_of_a_plan_can_be_simulated(cycle_us: int) -> None:
    for axes in (1, 3):
        assert plan(axes, cycle_us=cycle_us)
        cycles = max(4, 100_000 // cycle_us)
        seconds = cycles * cycle_us / 1e6
        done = simulate([0, seconds], [[0] * axes, [40] * axes], cycle_us=cycle_us)
        assert done.promises_kept and done.cycles == cycles + 1


def test_an_interrupt_ends_a_simulation() -> None:
    program = """
        from motion_board import simulate
        print("ready", flush=True)
        simulate([5 * step for step in range(100_000)], [[step % 2] for step in range(100_000)])
    """
    # Half a million seconds take minutes.
    with subprocess.Popen([sys.executable, "-c", textwrap.dedent(program)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None and child.stdout.readline() == "ready\n"
        time.sleep(0.5)
        begin = time.monotonic()
        child.send_signal(signal.SIGINT)
        try:
            _, told = child.communicate(timeout=20)
        finally:
            child.kill()
    assert "KeyboardInterrupt" in told and time.monotonic() - begin < 10
