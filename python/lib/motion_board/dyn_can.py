"""Messages of DYN2 and DYN4 drives on CAN, both revisions of their specification (1.2A and 1.6A).

Functions have the names of the documents, values have names that end in their unit. What decoding gives is what encoding takes::

    >>> frame = encode_request("Go_Relative_Pos_PD", drive=1, step_counts=-120)
    >>> str(frame)
    '03C 88'
    >>> decode_request(frame)
    Message(function='Go_Relative_Pos_PD', drive=1, values={'step_counts': -120})

Requests and replies share identifiers: which of the two a frame is, only its sender or the conversation tells.
:func:`motion_board.decode` follows the conversation.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Dict, Optional, Tuple

from . import _native
from .arguments import whole
from .errors import CodecError
from .frame import Frame, identifier

__all__ = [
    "Dialect",
    "Message",
    "decode_reply",
    "decode_request",
    "encode_reply",
    "encode_request",
]


@dataclass(frozen=True)
class Dialect:
    """How the documents are read where they leave a choice. ``None`` is the recommended reading of the revision.

    Change a value when a measurement on the drive says so. The numbers in brackets are those of ``docs/errata.md``.
    """

    revision: str = "1.6A"
    """"1.6A" or "1.2A"."""
    number_order: Optional[str] = None
    """Byte order of signed numbers: "msb" or "lsb" (D18, D26)."""
    group3_request_order: Optional[str] = None
    """Byte order in Set_Param_Group3: "msb" or "lsb" (D21)."""
    group3_reply_order_1_2a: Optional[str] = None
    """Byte order in the reply of 1.2A: "msb", "lsb" or "recognise" (D21)."""
    group3_reply_order_1_6a: Optional[str] = None
    """Byte order in the reply of 1.6A: "msb", "lsb" or "recognise" (D20)."""
    set_origin: Optional[int] = None
    """The byte of Set_Origin, -1 for none (D13, D14)."""
    torque_full_scale: Optional[int] = None
    """Torque at the peak current: 700 or 981 (D28)."""
    positive_torque: Optional[str] = None
    """"clockwise" or "counter-clockwise" (D30)."""
    read_dummy: Optional[int] = None
    """A data byte on requests that need none (D11)."""
    accept_beyond_28_bit: Optional[bool] = None
    """Accept a position beyond 28 bit (D16)."""
    strict_minimal: Optional[bool] = None
    """Refuse numbers in more bytes than they need (D25)."""
    zero_address: Optional[str] = None
    """What may go to every drive: "sync-trigger", "disable", "disable-and-speed-zero" or "lone-fresh-drive" (D2, D7)."""
    allow_assign_zero: Optional[bool] = None
    """Let Assign_Drive_ID store 0 (D2)."""


@dataclass(frozen=True)
class Message:
    """A request or a reply."""

    function: str
    """Name of the function, as the documents print it."""
    drive: Optional[int]
    """Drive id, None for every drive."""
    values: Dict[str, Any]
    """The values by their names."""


_RECOMMENDED = Dialect()


def encode_request(
    function: str, drive: Optional[int], dialect: Dialect = _RECOMMENDED, **values: Any
) -> Frame:
    """The frame of a request to a drive, or to every drive with ``drive=None``, where that is allowed.

    Raises :class:`motion_board.CodecError` for an unknown function, a value that is missing, unknown or out of range, and for
    what the dialect does not allow.
    """
    return Frame(*_native.dyn_can_encode_request(function, _drive(drive), values, asdict(dialect)))


def encode_reply(
    function: str, drive: Optional[int], dialect: Dialect = _RECOMMENDED, **values: Any
) -> Frame:
    """The frame of a reply, for simulated drives; ``function`` is that of the request, or Drive_Error."""
    return Frame(*_native.dyn_can_encode_reply(function, _drive(drive), values, asdict(dialect)))


def decode_request(frame: Frame, dialect: Dialect = _RECOMMENDED) -> Message:
    """A frame as a request.

    Raises :class:`motion_board.CodecError` for everything that the dialect does not allow as one.
    """
    return _message(_native.dyn_can_decode_request(*_data_frame(frame), asdict(dialect)))


def decode_reply(
    frame: Frame, asked: Optional[str] = None, dialect: Dialect = _RECOMMENDED
) -> Message:
    """A frame as a message of a drive.

    ``asked``: the function that was asked, as "Read_Drive_Status", or "position" or "torque" for General_Read, whose reply does not
    say which it is (D31); then nothing but its reply and Drive_Error decode. None: whatever does not depend on the request.
    """
    return _message(_native.dyn_can_decode_reply(*_data_frame(frame), asked, asdict(dialect)))


def _drive(drive: Optional[int]) -> Optional[int]:
    return None if drive is None else whole("drive", drive, 1, 63, CodecError)


def _data_frame(frame: Frame) -> Tuple[int, bytes]:
    if frame.extended or frame.remote:
        kind = "extended" if frame.extended else "remote"
        raise CodecError(f"DYN drives send and hear standard data frames, got another kind: {kind}")
    return identifier(frame), frame.data


def _message(fields: Dict[str, Any]) -> Message:
    function, drive = fields.pop("function"), fields.pop("drive")
    del fields["direction"]
    return Message(function, drive, fields)
