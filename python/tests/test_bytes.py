"""Bytes of any kind are taken wherever bytes are, as the ``bytearray`` of a message of python-can."""

from __future__ import annotations

from typing import Any, Callable

import numpy
import pytest

from motion_board import CodecError, Decoder, Frame, Settings, canopen, dyn_can, dyn_serial
from motion_board.testing import SimulatedBoard

KINDS: "list[Callable[[bytes], Any]]" = [
    bytes,
    bytearray,
    memoryview,
    lambda data: memoryview(bytes(2 * len(data)))[::2] if not any(data) else memoryview(data[::-1])[::-1],
    lambda data: numpy.frombuffer(data, numpy.uint8),
]
STEP = dyn_can.encode_request("Go_Relative_Pos_PD", drive=1, step_counts=-300)
SPEED = (100).to_bytes(4, "little")


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_bytes_is_taken(kind: Callable[[bytes], Any]) -> None:
    frame = Frame(STEP.id, kind(STEP.data))
    assert frame == STEP and hash(frame) == hash(STEP) and type(frame.data) is bytes
    assert dyn_can.decode_request(frame).values == {"step_counts": -300}
    assert dyn_can.decode_reply(Frame(0x0AE, kind(b"\xff\x63")), "torque").values["torque"] == -157
    assert Decoder().hear(frame, 0.0) == Decoder().hear(STEP, 0.0)
    assert dyn_can.encode_reply("Echo_Function", 1, bytes=kind(b"abcd")).data == b"abcd"
    written = canopen.sdo_write(4, 0x60FF, 0, SPEED)
    assert canopen.sdo_write(4, 0x60FF, 0, kind(SPEED)) == written
    assert canopen.decode(Frame(written.id, kind(written.data)))["service"] == "SDO request"
    assert canopen.sdo_value(4, 0x60FF, 0, kind(SPEED)) == canopen.sdo_value(4, 0x60FF, 0, SPEED)
    assert canopen.rpdo(4, 0, [(0x60FF, 0, kind(SPEED))]) == canopen.rpdo(4, 0, [(0x60FF, 0, SPEED)])
    packet = bytes.fromhex("03 99 81 9d")
    assert dyn_serial.decode_reply(kind(packet)) == dyn_serial.decode_reply(packet)
    request = dyn_serial.encode_request("Turn_ConstSpeed", drive=8, speed_rpm=50)
    assert dyn_serial.decode_request(kind(request)) == dyn_serial.decode_request(request)
    assert dyn_serial.StreamDecoder().push(kind(packet)) == [("packet", packet)]
    with pytest.raises(CodecError):
        Settings(kind(b"abc")).text
    with SimulatedBoard(axes=1, settings=kind(b"abc")):
        pass


def test_bytes_do_not_change_behind_a_frame() -> None:
    data = bytearray(b"\x88")
    frame = Frame(0x03C, data)
    data[0] = 0
    assert frame.data == b"\x88"


@pytest.mark.parametrize("data", ("88", 8, None, [1, 2], numpy.array([1, 2])))
def test_what_holds_no_bytes_is_no_data(data: Any) -> None:
    with pytest.raises(TypeError, match="data: expected bytes, got"):
        Frame(0x03C, data)
    with pytest.raises(TypeError, match="data: expected bytes, got"):
        canopen.rpdo(4, 0, [(0x60FF, 0, data)])
    for take in (dyn_serial.StreamDecoder().push, dyn_serial.decode_reply):
        with pytest.raises(TypeError):
            take(data)
