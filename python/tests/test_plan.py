"""The bus plan, and compared with the tool."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any, Callable, Dict, List

import numpy
import pytest

from motion_board import InputError, plan


def test_eight_axes_fit_and_fourteen_do_not() -> None:
    good = plan(8)
    assert good and good.refusal is None and good.most_axes == 11
    assert all(frame.in_time and frame.response_us is not None for frame in good.frames)
    assert [frame.first_id for frame in good.frames[:2]] == [0x03C, 0x05C]
    bad = plan(14)
    assert not bad and bad.refusal == "set-point of drive 13 does not fit: with it a cycle carries 1061 bit times, but lasts 1000"
    assert bad.remedies


@pytest.mark.parametrize(
    ("changes", "text"),
    (
        ({"bit_rate_kbit": 100}, "bit_rate_kbit: expected 10, 20, 50"),
        ({"cycle_us": 10}, "cycle_us: expected 250 to 1000000, got 10"),
        ({"requests": 0}, "requests: expected 1"),
        ({"response_us": (5, 4)}, "response_us: expected the shortest"),
        ({"axes": []}, "drives: expected at least one"),
        ({"axes": [1, 1]}, "drives: expected each drive once, got 1 twice"),
        ({"axes": [1, 64]}, "axes, drive 1: expected 1 to 63, got 64"),
        ({"axes": 64}, "axes: expected 1 to 63, got 64"),
        ({"axes": -1}, "axes: expected 1 to 63, got -1"),
        ({"axes": True}, "axes: expected 1 to 63, got True"),
        ({"axes": 1.0}, "axes: expected 1 to 63, got 1.0"),
        ({"axes": "12"}, "axes: expected drive ids"),
        ({"status_hz": -1}, "status_hz: expected 0 to 1000000, got -1"),
        ({"status_hz": 0.5}, "status_hz: expected 0 to 1000000, got 0.5"),
        ({"status_hz": 2_000_000}, "status_hz: expected 0 to 1000000, got 2000000"),
        ({"counter_hz": 2_000_000}, "counter_hz: expected 0 to 1000000, got 2000000"),
        ({"response_us": 375}, "response_us: expected the shortest and the longest, got 375"),
        ({"response_us": (1, 2, 3)}, "response_us: expected the shortest and the longest, got (1, 2, 3)"),
        ({"response_us": (-1, 2)}, "response_us: expected 0 to 4294967295, got -1"),
        ({"alarms": 256}, "alarms: expected 0 to 255, got 256"),
        ({"tx_order": None}, "tx_order: expected fifo or identifier, got None"),
        ({"tx_order": "random"}, "tx_order: expected fifo or identifier"),
        ({"max_step_counts": 0}, "max_step_counts"),
        ({"error_interval_us": 0}, "error_interval_us"),
    ),
)
def test_what_makes_no_sense_is_refused(changes: Dict[str, Any], text: str) -> None:
    with pytest.raises(InputError) as caught:
        plan(**changes)
    assert text in str(caught.value)


@pytest.mark.parametrize(
    ("options", "changes"),
    (
        ([], {}),
        (["--axes", "14"], {"axes": 14}),
        (["--drives", "3,7-9", "--bit-rate", "500", "--cycle-us", "2000"], {"axes": [9, 3, 7, 8], "bit_rate_kbit": 500, "cycle_us": 2000}),
        (
            ["--axes", "6", "--alarms", "1", "--error-interval-us", "10000", "--tx-order", "identifier"],
            {"axes": 6, "alarms": 1, "error_interval_us": 10000, "tx_order": "identifier"},
        ),
        (["--axes", "3", "--torque-hz", "10", "--speed-hz", "5", "--counter-hz", "1", "--any-request"],
         {"axes": 3, "torque_hz": 10, "speed_hz": 5, "counter_hz": 1, "any_request": True}),
    ),
)
def test_the_verdict_is_that_of_the_tool(
    options: List[str], changes: Dict[str, Any], motionctl: Callable[..., str]
) -> None:
    assert asdict(plan(**changes)) == json.loads(motionctl("plan", "--json", *options))


@pytest.mark.parametrize("axes", (numpy.int64(8), numpy.uint8(8), numpy.array(8), range(1, 9), numpy.arange(1, 9), {*range(1, 9)}))
def test_axes_are_any_whole_number_or_drive_ids(axes: Any) -> None:
    assert plan(axes) == plan(8)


@pytest.mark.parametrize("response", ([375, 625], numpy.array([375, 625])))
def test_responses_are_any_two_numbers(response: Any) -> None:
    fifty: Any = numpy.int64(50)
    assert plan(response_us=response, status_hz=fifty) == plan()


def test_a_poll_a_microsecond_is_the_fastest() -> None:
    rows = [frame for frame in plan(1, status_hz=1_000_000).frames if "status" in frame.frame]
    assert rows and {frame.period_us for frame in rows} == {1}
