"""Frames of CANopen against the vectors of an independent reference."""

from __future__ import annotations

from typing import Any, Dict

import pytest
from conftest import vectors

from motion_board import CodecError, Decoder, Frame, canopen

SDO = vectors("zlac_sdo")
MISC = vectors("zlac_misc")


def frame_of(vector: Dict[str, Any]) -> Frame:
    return Frame(vector["can_id"], bytes.fromhex(vector["data"]))


@pytest.mark.parametrize(
    "vector", [one for one in SDO if one["kind"] in ("write", "read") and one.get("canonical", True)], ids=lambda one: one["name"]
)
def test_an_sdo_request_is_the_frame_of_the_reference(vector: Dict[str, Any]) -> None:
    node, index, sub = vector["node"], vector["index"], vector["sub"]
    if vector["kind"] == "read":
        frame = canopen.sdo_read(node, index, sub)
    else:
        size, value = vector["size"], vector["value"]
        frame = canopen.sdo_write(node, index, sub, value.to_bytes(size, "little", signed=value < 0))
    assert frame == frame_of(vector)
    said = canopen.decode(frame)
    assert (said["protocol"], said["node"], said["service"]) == ("canopen", node, "SDO request")


@pytest.mark.parametrize("vector", [one for one in MISC if one["kind"] == "nmt"], ids=lambda one: one["name"])
def test_nmt_is_the_frame_of_the_reference(vector: Dict[str, Any]) -> None:
    command = vector["command"].replace("_", "-")
    frame = canopen.nmt(command, vector["node"] or None)
    assert frame == frame_of(vector)
    assert canopen.decode(frame)["service"] == "NMT"


def test_process_data_is_packed_as_it_is_read_with_its_mapping() -> None:
    decoder = Decoder("canopen")
    # TPDO 0 of node 4 carries the status word and the actual speed (6041h 16 bit, 606Ch 32 bit).
    setup = [(0x1A00, 0, b"\0"), (0x1A00, 1, b"\x10\0\x41\x60"), (0x1A00, 2, b"\x20\0\x6c\x60"), (0x1A00, 0, b"\2")]
    for index, sub, data in setup:
        decoder.hear(canopen.sdo_write(4, index, sub, data))
        decoder.hear(canopen.sdo_written(4, index, sub))
    speed = (-1000).to_bytes(4, "little", signed=True)
    frame = canopen.tpdo(4, 0, [(0x6041, 0, b"\x37\x02"), (0x606C, 0, speed)])
    assert frame == Frame(0x184, b"\x37\x02" + speed)
    said = decoder.hear(frame)
    assert list(said["objects"]) == [("6041h:00", 0x237), ("606Ch:00", -1000)]


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(CodecError, match="1 to 4 bytes, got 5"):
        canopen.sdo_write(4, 0x60FF, 0, bytes(5))
    with pytest.raises(CodecError, match="128"):
        canopen.sdo_read(128, 0x60FF)
    with pytest.raises(CodecError, match="expected start, stop"):
        canopen.nmt("go", 4)
    with pytest.raises(CodecError):
        canopen.rpdo(4, 0, [(0x6041, 0, bytes(4)), (0x6042, 0, bytes(4)), (0x6043, 0, bytes(4))])
    with pytest.raises(CodecError, match="0 to 3"):
        canopen.rpdo(4, 4, [])


@pytest.mark.parametrize("number", (2**16, 2**40, -1, 1.5, None))
def test_a_number_that_fits_nowhere_is_an_error_of_the_codec(number: Any) -> None:
    with pytest.raises(CodecError, match="index: expected 0 to 65535, got"):
        canopen.sdo_read(1, number)
    with pytest.raises(CodecError, match="sub: expected 0 to 255, got"):
        canopen.sdo_written(1, 0x6041, number)
    with pytest.raises(CodecError, match="node: expected 1 to 127, got"):
        canopen.sdo_read(number, 0x6041)
    with pytest.raises(CodecError, match="id: expected 0 to 2047, got"):
        canopen.decode(Frame(number))
    with pytest.raises(CodecError, match="id: expected 0 to 536870911, got"):
        Decoder("canopen").hear(Frame(2**29 if number == 2**16 else number, extended=True))
    with pytest.raises(CodecError, match="number: expected 0 to 3, got"):
        canopen.rpdo(4, number, [])
    with pytest.raises(CodecError, match="index: expected 0 to 65535, got"):
        canopen.tpdo(4, 0, [(number, 0, b"x")])
    with pytest.raises(CodecError, match="code: expected 0 to 4294967295, got"):
        canopen.sdo_abort(4, 0x6041, 0, -1 if number == 2**16 else 2**32)
    with pytest.raises(CodecError, match="node: expected 1 to 127, got"):
        canopen.heartbeat(number, "stopped")
