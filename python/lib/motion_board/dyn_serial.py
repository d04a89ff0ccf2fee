"""Packets of DYN2 and DYN4 drives on RS232 (DYN232M).

The functions differ from those on CAN from 10h on, and replies have names of their own ("Is_Status")::

    >>> encode_request("Turn_ConstSpeed", drive=8, speed_rpm=50).hex(" ")
    '08 8a b2 c4'
    >>> decode_reply(bytes.fromhex("03 99 81 9d"))
    ... # doctest: +ELLIPSIS
    Message(function='Is_Status', drive=3, values={...})
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, List, NamedTuple, Optional, Tuple

from . import _native
from .arguments import BytesLike, whole
from .dyn_can import Message
from .errors import CodecError

__all__ = [
    "Dialect",
    "Event",
    "Message",
    "StreamDecoder",
    "decode_reply",
    "decode_request",
    "encode_reply",
    "encode_request",
]


@dataclass(frozen=True)
class Dialect:
    """How the manual is read where it leaves a choice."""

    parameter_form: str = "table"
    """How parameters are sent: "table", or "shortest-signed" as the sample code does (M12, M13)."""
    dummy: int = 0
    """The byte of functions without data, 0 to 127."""
    general_id: str = "coordinated-moves"
    """What may go to every drive: "coordinated-moves", "stop" or "lone-drive" (M24)."""

    def _words(self) -> Tuple[str, int, str]:
        return self.parameter_form, whole("dummy", self.dummy, 0, 127, CodecError), self.general_id


_RECOMMENDED = Dialect()


def encode_request(
    function: str, drive: Optional[int], dialect: Dialect = _RECOMMENDED, **values: Any
) -> bytes:
    """The packet of a request to a drive, 0 to 63, or to every drive with ``drive=None``, where that is allowed.

    Raises :class:`motion_board.CodecError` as :func:`motion_board.dyn_can.encode_request` does.
    """
    to = None if drive is None else _drive(drive)
    return _native.dyn_serial_encode_request(function, to, values, dialect._words())


def encode_reply(function: str, drive: int, **values: Any) -> bytes:
    """The packet of a reply, for simulated drives."""
    return _native.dyn_serial_encode_reply(function, _drive(drive), values)


def decode_request(packet: BytesLike, dialect: Dialect = _RECOMMENDED) -> Message:
    """A whole packet as a request.

    Raises :class:`motion_board.CodecError` for a wrong checksum, length or byte, and for what is no request.
    """
    drive, function, values = _native.dyn_serial_decode_request(packet, dialect._words())
    return Message(function, drive, values)


def decode_reply(packet: BytesLike) -> Message:
    """A whole packet as a message of a drive."""
    drive, function, values = _native.dyn_serial_decode_reply(packet)
    return Message(function, drive, values)


def _drive(drive: int) -> int:
    return whole("drive", drive, 0, 63, CodecError)


class Event(NamedTuple):
    """What a stream of bytes had next."""

    kind: str
    """"packet", "stray" (a byte outside of a packet), "truncated" or "checksum" (a packet whose last byte is wrong)."""
    data: bytes
    """Its bytes."""


class StreamDecoder:
    """Finds packets in a stream of bytes, whatever else is in it: no intact packet is lost, no byte is unaccounted for."""

    def __init__(self) -> None:
        """Before the first byte."""
        self._decoder = _native.SerialDecoder()

    def push(self, data: BytesLike) -> List[Event]:
        """Takes bytes as they come, and gives what is complete."""
        return [Event(kind, part) for kind, part in self._decoder.push(data)]
