"""The codec of DYN CAN against the vectors of an independent reference, and its errors."""

from __future__ import annotations

from typing import Any, Dict, Optional, Tuple

import pytest
from conftest import vectors

from motion_board import CodecError, Frame
from motion_board.dyn_can import Dialect, decode_reply, decode_request, encode_reply, encode_request

GROUPS = ("Set_Param_Group1", "Set_Param_Group2", "Set_Param_Group3")


def values_of(command: str, args: Dict[str, Any]) -> Dict[str, Any]:
    """The values of a vector by our names."""
    if command in GROUPS:
        return {name: value or None for name, value in args.items()}
    renamed: Dict[str, Any] = {}
    for name, value in args.items():
        if name == "position_counts":
            renamed["target_counts"] = value
        elif name == "distance_counts" and command == "Go_Relative_Pos_PD":
            renamed["step_counts"] = value
        elif name == "value_counts":
            renamed["word_counts"] = value
        elif name == "amplitude_counts":
            renamed["amplitude"] = value
        elif name == "disable":
            renamed["enable"] = not value
        elif name == "kind":
            renamed["absolute"] = {"absolute": True, "relative": False}.get(value, value)
        elif name == "new_drive_id":
            renamed["drive_id"] = value
        elif name == "what":
            renamed["reads"] = value
        elif name == "payload_hex":
            renamed["bytes"] = tuple(bytes.fromhex(value))
        elif name == "disabled":
            renamed["servo_free"] = value
        else:
            renamed[name] = value
    return renamed


ORDERS = {"auto": "recognise", "big": "msb", "little": "lsb"}


OPTIONS = {"group3_reply_order_12a": "group3_reply_order_1_2a", "group3_reply_order_16a": "group3_reply_order_1_6a"}


def dialect_of(vector: Dict[str, Any]) -> Dialect:
    """The readings that a vector needs."""
    # The reference reads this reply as it is printed; by default we recognise its order.
    options: Dict[str, Any] = {"group3_reply_order_1_6a": "lsb"}
    for name, value in vector.get("options", {}).items():
        if name == "allow_broadcast":
            options["zero_address"] = "lone-fresh-drive" if value else None
        else:
            options[OPTIONS.get(name, str(name))] = ORDERS.get(value, value)
    return Dialect(vector["revision"], **options)


def drive_of(vector: Dict[str, Any]) -> Optional[int]:
    return vector["drive_id"] or None


@pytest.mark.parametrize("vector", vectors("dyn_can_requests"), ids=lambda vector: vector["name"])
def test_a_request_is_the_frame_of_the_reference_and_back(vector: Dict[str, Any]) -> None:
    dialect = dialect_of(vector)
    values = values_of(vector["command"], vector["args"])
    frame = encode_request(vector["command"], drive_of(vector), dialect, **values)
    assert frame == Frame(vector["can_id"], bytes.fromhex(vector["data"]))
    message = decode_request(frame, dialect)
    assert (message.function, message.drive) == (vector["command"], drive_of(vector))
    assert {name: message.values[name] for name in values} == values
    # All that is decoded can be encoded.
    assert encode_request(message.function, message.drive, dialect, **message.values) == frame


REPLY_NAMES: Dict[str, str] = {"torque_raw": "torque", "full_scale": "torque_full_scale", "servo_disabled": "disabled", "alarm": "alarm_code", "disabled": "servo_free"}


def reply_values(vector: Dict[str, Any]) -> Dict[str, Any]:
    fields = dict(vector["fields"])
    command = vector["command"]
    if command == "Drive_Error":
        texts = {0xFF: "data error", 0xEE: "alarm"}
        raw = fields["raw"]
        return {"drive_error": texts.get(raw, f"undocumented error 0x{raw:02X}")}
    if command == "Drive_Reset":
        return {"answer": fields["raw"]}
    fields.pop("what", None)
    fields.pop("alarm_text", None)
    if "payload_hex" in fields:
        return {"bytes": tuple(bytes.fromhex(fields["payload_hex"]))}
    return {REPLY_NAMES.get(str(name), str(name)): value for name, value in fields.items()}


@pytest.mark.parametrize("vector", vectors("dyn_can_replies"), ids=lambda vector: vector["name"])
def test_a_reply_says_what_the_reference_says(vector: Dict[str, Any]) -> None:
    dialect = dialect_of(vector)
    frame = Frame(vector["can_id"], bytes.fromhex(vector["data"]))
    what = vector["context"].get("what")
    asked = what if what else None
    message = decode_reply(frame, asked, dialect)
    assert (message.function, message.drive) == (vector["command"], drive_of(vector))
    wanted = reply_values(vector)
    known = {name: value for name, value in wanted.items() if name in message.values}
    assert known and {name: message.values[name] for name in known} == known
    if vector["canonical"]:
        again = encode_reply(message.function, message.drive, dialect, **message.values)
        assert (again.id, len(again.data)) == (frame.id, len(frame.data))
        assert decode_reply(again, asked, dialect) == message


REFUSED = vectors("dyn_can_rejects")


@pytest.mark.parametrize("vector", REFUSED, ids=lambda vector: vector["name"])
def test_what_the_reference_refuses_is_refused(vector: Dict[str, Any]) -> None:
    dialect = dialect_of(vector)
    with pytest.raises(CodecError):
        if vector["stage"] == "encode_request":
            values = values_of(vector["command"], vector["args"])
            encode_request(vector["command"], drive_of(vector), dialect, **values)
        else:
            given = vector["frame"]
            frame = Frame(given["can_id"], bytes.fromhex(given["data"]), given["extended"], given["remote"])
            if vector["stage"] == "decode_request":
                decode_request(frame, dialect)
            else:
                asked = (vector.get("context") or {}).get("what")
                message = decode_reply(frame, asked, dialect)
                # A torque beyond its scale is handed on, in doubt.
                if message.values.get("torque_in_doubt"):
                    raise CodecError("in doubt")


CASES: Tuple[Tuple[str, Dict[str, Any], str], ...] = (
    ("Go_Fast", {}, "no function is called Go_Fast: expected one of Set_Origin, "),
    ("Go_Relative_Pos_PD", {}, "Go_Relative_Pos_PD needs the value step_counts"),
    ("Go_Relative_Pos_PD", {"step_counts": 16385}, "Go_Relative_Pos_PD: step_counts: PD step in counts must be -16384..=16384, got 16385"),
    ("Go_Relative_Pos_PD", {"step_counts": 1, "speed": 2}, "Go_Relative_Pos_PD has no value speed: expected ['step_counts']"),
    ("Go_Relative_Pos_PD", {"step_counts": "far"}, "Go_Relative_Pos_PD: step_counts: "),
    ("Go_Relative_Pos_PD", {"step_counts": 1.5}, "Go_Relative_Pos_PD: step_counts: "),
    ("General_Read", {"reads": "speed"}, "General_Read: reads: expected position or torque, got speed"),
    ("Drive_Error", {}, "Drive_Error (0x1D) is no request"),
)


@pytest.mark.parametrize(("function", "values", "text"), CASES)
def test_a_wrong_value_is_named(function: str, values: Dict[str, Any], text: str) -> None:
    with pytest.raises(CodecError) as caught:
        encode_request(function, 1, **values)
    assert text in str(caught.value)


def test_values_that_contradict_each_other_are_refused() -> None:
    whole = decode_request(encode_request("Set_Drive_Config", 1, config=0x17)).values
    assert whole["command_mode"] == 3
    with pytest.raises(CodecError, match="command_mode: got 1, with the other values the message carries 3"):
        encode_request("Set_Drive_Config", 1, **{**whole, "command_mode": 1})


def test_every_drive_hears_only_what_the_dialect_allows() -> None:
    with pytest.raises(CodecError, match="may not be broadcast"):
        encode_request("Servo_Disable", None, enable=False)
    frame = encode_request("Servo_Disable", None, Dialect(zero_address="disable"), enable=False)
    assert str(frame) == "019 FF"
    with pytest.raises(CodecError, match="may not be broadcast"):
        encode_request("Servo_Disable", None, Dialect(zero_address="disable"), enable=True)
    with pytest.raises(CodecError, match="zero_address: expected one of sync-trigger"):
        encode_request("Servo_Disable", None, Dialect(zero_address="all"), enable=False)


def test_byte_orders_and_revisions_are_the_dialect() -> None:
    lsb = Dialect(number_order="lsb")
    assert encode_request("Go_Relative_Pos_PD", 1, lsb, step_counts=300).data == bytes([0x2C, 0x01])
    assert encode_request("Set_Origin", 1, Dialect("1.2A")).data == b"\xff"
    assert encode_request("Set_Origin", 1, Dialect(set_origin=-1)).data == b""
    with pytest.raises(CodecError, match="Drive_Reset"):
        encode_request("Drive_Reset", 1, Dialect("1.2A"))


def test_a_torque_needs_its_request() -> None:
    frame = Frame(0x0AE, bytes([0xFF, 0x63]))
    with pytest.raises(CodecError, match="position and torque look alike"):
        decode_reply(frame)
    torque = decode_reply(frame, "torque").values
    assert torque["torque"] == -157 and torque["torque_share_clockwise"] == pytest.approx(-157 / 981)
    other = decode_reply(frame, "torque", Dialect("1.2A")).values
    assert other["torque_share_clockwise"] == pytest.approx(157 / 700)


@pytest.mark.parametrize("number", (70000, -1, 2**40, 1.0, True, None))
def test_a_number_that_fits_nowhere_is_an_error_of_the_codec(number: Any) -> None:
    with pytest.raises(CodecError, match="id: expected 0 to 2047, got"):
        decode_request(Frame(number))
    with pytest.raises(CodecError, match="id: expected 0 to 2047, got"):
        decode_reply(Frame(number))
    if number is not None:
        with pytest.raises(CodecError, match="drive: expected 1 to 63, got"):
            encode_request("Set_Origin", drive=number)
        with pytest.raises(CodecError, match="drive: expected 1 to 63, got"):
            encode_reply("Echo_Function", drive=number, bytes=bytes(4))


@pytest.mark.parametrize(
    ("name", "value", "text"),
    (
        ("read_dummy", 300, "dialect: read_dummy: expected 0 to 255, got 300"),
        ("read_dummy", "x", "dialect: read_dummy: expected 0 to 255, got x"),
        ("set_origin", 70000, "dialect: set_origin: expected 0 to 255, or -1 for no byte, got 70000"),
        ("set_origin", -2, "dialect: set_origin: expected 0 to 255, or -1 for no byte, got -2"),
        ("strict_minimal", 1, "dialect: strict_minimal: expected True or False, got 1"),
    ),
)
def test_a_dialect_that_cannot_be_is_named(name: str, value: Any, text: str) -> None:
    with pytest.raises(CodecError) as caught:
        encode_request("Set_Origin", 1, Dialect(**{name: value}))
    assert text in str(caught.value)


def test_a_value_that_fits_nowhere_is_shown() -> None:
    with pytest.raises(CodecError, match="step_counts: .*, got 1099511627776"):
        encode_request("Go_Relative_Pos_PD", 1, step_counts=2**40)
