"""The codec of DYN232M against the vectors of an independent reference."""

from __future__ import annotations

from typing import Any, Dict, List, Optional

import pytest
from conftest import vectors

from motion_board import CodecError
from motion_board.dyn_serial import Dialect, StreamDecoder, decode_reply, decode_request, encode_reply, encode_request

# Make_LinearLine and Make_CircularArc may go to every drive, as do requests of the reference.
VECTORS = vectors("dyn232m")
NAMES = {
    "Go_Absolute_Pos": "target_counts",
    "Go_Relative_Pos": "distance_counts",
    "Make_LinearLine": "word_counts",
    "Make_CircularArc": "word_counts",
    "Assign_Drive_ID": "drive_id",
    "Set_Drive_Config": "config",
    "Turn_ConstSpeed": "speed_rpm",
    "Square_Wave": "amplitude",
    "Sin_Wave": "amplitude",
    "SS_Frequency": "frequency_hz",
    "Set_MainGain": "main_gain",
    "Set_SpeedGain": "speed_gain",
    "Set_IntGain": "integration_gain",
    "Set_TrqCons": "torque_filter",
    "Set_HighSpeed": "max_speed",
    "Set_HighAccel": "max_acceleration",
    "Set_Pos_OnRange": "on_pos_range",
    "Set_GearNumber": "gear_number",
    "Is_MainGain": "main_gain",
    "Is_SpeedGain": "speed_gain",
    "Is_IntGain": "integration_gain",
    "Is_TrqCons": "torque_filter",
    "Is_HighSpeed": "max_speed",
    "Is_HighAccel": "max_acceleration",
    "Is_Drive_ID": "drive_id",
    "Is_PosOn_Range": "on_pos_range",
    "Is_GearNumber": "gear_number",
    "Is_Config": "config",
    "Is_AbsPos32": "position_counts",
    "Is_TrqCurrent": "torque",
}


def of_kind(kind: str) -> List[Any]:
    """The vectors of a kind by their names."""
    chosen = [pytest.param(one, id=one.get("name", one["id"])) for one in VECTORS if one["kind"] == kind]
    assert chosen
    return chosen


def drive_of(vector: Dict[str, Any]) -> Optional[int]:
    drive: int = vector["drive_id"]
    return None if drive == 127 else drive


def values_of(vector: Dict[str, Any]) -> Dict[str, Any]:
    function, value = vector["function"], vector["value"]
    if function == "General_Read":
        return {"reads": {0x1B: "position", 0x1E: "torque"}.get(value, value)}
    return {NAMES[function]: value} if function in NAMES else {}


@pytest.mark.parametrize("vector", of_kind("request"))
def test_a_request_is_the_packet_of_the_reference_and_back(vector: Dict[str, Any]) -> None:
    values = values_of(vector)
    dummy = 0 if values else vector["value"]
    dialect = Dialect(dummy=dummy, general_id="lone-drive")
    packet = encode_request(vector["function"], drive_of(vector), dialect, **values)
    assert packet.hex() == vector["packet"]
    message = decode_request(packet, dialect)
    assert (message.function, message.drive, message.values) == (vector["function"], drive_of(vector), values)


@pytest.mark.parametrize("vector", of_kind("reply"))
def test_a_reply_says_what_the_reference_says(vector: Dict[str, Any]) -> None:
    packet = bytes.fromhex(vector["packet"])
    message = decode_reply(packet)
    assert message.drive == vector["drive_id"]
    if vector["function"] in NAMES:
        assert message.values == {NAMES[vector["function"]]: vector["value"]}
    else:
        value = vector["value"]
        assert message.values["on_position"] == (value & 1 == 0)
        assert message.values["alarm_code"] == value >> 2 & 7
        assert message.values["motion_busy"] == bool(value & 0x20)
    assert encode_reply(message.function, vector["drive_id"], **message.values) == packet


@pytest.mark.parametrize("vector", of_kind("reject_packet"))
def test_a_packet_that_the_reference_refuses_is_refused(vector: Dict[str, Any]) -> None:
    with pytest.raises(CodecError):
        decode_reply(bytes.fromhex(vector["packet"]))


@pytest.mark.parametrize("vector", of_kind("reject_request"))
def test_a_request_that_the_reference_refuses_is_refused(vector: Dict[str, Any]) -> None:
    with pytest.raises(CodecError):
        encode_request(vector["function"], drive_of(vector), **values_of(vector))


@pytest.mark.parametrize("vector", of_kind("stream"))
def test_packets_are_found_in_a_stream(vector: Dict[str, Any]) -> None:
    events = StreamDecoder().push(bytes.fromhex(vector["stream"]))
    assert [(event.kind, event.data.hex()) for event in events] == [
        (event["event"], event["bytes"]) for event in vector["events"]
    ]


def test_the_form_of_the_sample_code_is_the_dialect() -> None:
    form = Dialect(parameter_form="shortest-signed")
    assert encode_request("Set_MainGain", 5, form, main_gain=64).hex() == "05b080c0f5"
    with pytest.raises(CodecError, match="parameter_form: expected table or shortest-signed"):
        encode_request("Set_MainGain", 5, Dialect(parameter_form="long"), main_gain=64)


@pytest.mark.parametrize("number", (64, 2**40, -1, 1.5))
def test_a_drive_that_cannot_be_is_an_error_of_the_codec(number: Any) -> None:
    with pytest.raises(CodecError, match="drive: expected 0 to 63, got"):
        encode_request("Set_Origin", number)
    with pytest.raises(CodecError, match="drive: expected 0 to 63, got"):
        encode_reply("Is_MainGain", number, main_gain=5)
    with pytest.raises(CodecError, match="dummy: expected 0 to 127, got"):
        encode_request("Set_Origin", 1, Dialect(dummy=number * 1000))
