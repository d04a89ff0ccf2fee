"""Frames for ZLAC8030L hub-motor drives on CANopen (CiA 301), and what frames say.

Numbers in objects are little-endian, so their width matters: ``int.to_bytes(4, "little", signed=True)`` for 60FFh::

    >>> str(sdo_write(4, 0x60FF, 0, (100).to_bytes(4, "little")))
    '604 23 FF 60 00 64 00 00 00'
    >>> decode(Frame(0x584, bytes.fromhex("60FF600000000000")))["text"]
    'from node 4   SDO reply: 60FFh:00 target speed written - nobody asked: late, or repeated'
"""

from __future__ import annotations

from typing import Any, Dict, Optional, Sequence, Tuple

from . import _native
from .arguments import BytesLike, octets, whole
from .errors import CodecError
from .frame import Frame, identifier

__all__ = [
    "decode",
    "heartbeat",
    "nmt",
    "rpdo",
    "sdo_abort",
    "sdo_read",
    "sdo_value",
    "sdo_write",
    "sdo_written",
    "sync",
    "tpdo",
]

Mapped = Tuple[int, int, BytesLike]
"""Index, sub-index and value of an object in a PDO, least significant byte first."""


def nmt(command: str, node: Optional[int] = None) -> Frame:
    """Network management: "start", "stop", "pre-operational", "reset-node" or "reset-communication", to every node with None."""
    return Frame(*_native.canopen_nmt(command, None if node is None else _node(node)))


def sync() -> Frame:
    """SYNC."""
    return Frame(*_native.canopen_sync())


def heartbeat(node: int, state: str) -> Frame:
    """The heartbeat of a node: "boot-up", "stopped", "operational" or "pre-operational"."""
    return Frame(*_native.canopen_heartbeat(_node(node), state))


def sdo_read(node: int, index: int, sub: int = 0) -> Frame:
    """Read an object."""
    return Frame(*_native.canopen_sdo_read(*_object(node, index, sub)))


def sdo_write(node: int, index: int, sub: int, data: BytesLike) -> Frame:
    """Write an object of 1 to 4 bytes, least significant byte first."""
    return Frame(*_native.canopen_sdo_write(*_object(node, index, sub), data))


def sdo_value(node: int, index: int, sub: int, data: BytesLike) -> Frame:
    """The reply to a read, for simulated drives."""
    return Frame(*_native.canopen_sdo_value(*_object(node, index, sub), data))


def sdo_written(node: int, index: int, sub: int = 0) -> Frame:
    """The reply to a write, for simulated drives."""
    return Frame(*_native.canopen_sdo_written(*_object(node, index, sub)))


def sdo_abort(node: int, index: int, sub: int, code: int) -> Frame:
    """The reply of a drive that refuses, with an abort code of CiA 301."""
    reason = whole("code", code, 0, 0xFFFF_FFFF, CodecError)
    return Frame(*_native.canopen_sdo_abort(*_object(node, index, sub), reason))


def rpdo(node: int, number: int, objects: Sequence[Mapped]) -> Frame:
    """Process data to a drive, number 0 to 3; the objects must be mapped like this in the drive."""
    return _pdo(True, node, number, objects)


def tpdo(node: int, number: int, objects: Sequence[Mapped]) -> Frame:
    """Process data from a drive, for simulated drives."""
    return _pdo(False, node, number, objects)


def decode(frame: Frame) -> Dict[str, Any]:
    """What one frame says by itself, with the names of ``motionctl decode --json``.

    It knows of no request, and of no mapping of a PDO: use :class:`motion_board.Decoder` for a conversation.
    """
    decoder = _native.FrameDecoder("canopen", None, 10.0)
    return decoder.hear(identifier(frame), *frame[1:], None)


def _node(node: int) -> int:
    return whole("node", node, 1, 127, CodecError)


def _object(node: int, index: int, sub: int) -> Tuple[int, int, int]:
    index, sub = whole("index", index, 0, 0xFFFF, CodecError), whole("sub", sub, 0, 0xFF, CodecError)
    return _node(node), index, sub


def _pdo(to_drive: bool, node: int, number: int, objects: Sequence[Mapped]) -> Frame:
    values = [(*_object(node, index, sub)[1:], octets("data", data)) for index, sub, data in objects]
    number = whole("number", number, 0, 3, CodecError)
    return Frame(*_native.canopen_pdo(to_drive, _node(node), number, values))
