"""The bus plan, and compared with the tool."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any, Callable, Dict, List

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
        ({"axes": [64]}, "drive id must be 1..=63, got 64"),
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
