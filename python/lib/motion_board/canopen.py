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
from .frame import Frame

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

Mapped = Tuple[int, int, bytes]
"""Index, sub-index and value of an object in a PDO, least significant byte first."""


def nmt(command: str, node: Optional[int] = None) -> Frame:
    """Network management: "start", "stop", "pre-operational", "reset-node" or "reset-communication", to every node with None."""
    return Frame(*_native.canopen_nmt(command, node))


def sync() -> Frame:
    """SYNC."""
    return Frame(*_native.canopen_sync())


def heartbeat(node: int, state: str) -> Frame:
    """The heartbeat of a node: "boot-up", "stopped", "operational" or "pre-operational"."""
    return Frame(*_native.canopen_heartbeat(node, state))


def sdo_read(node: int, index: int, sub: int = 0) -> Frame:
    """Read an object."""
    return Frame(*_native.canopen_sdo_read(node, index, sub))


def sdo_write(node: int, index: int, sub: int, data: bytes) -> Frame:
    """Write an object of 1 to 4 bytes, least significant byte first."""
    return Frame(*_native.canopen_sdo_write(node, index, sub, data))


def sdo_value(node: int, index: int, sub: int, data: bytes) -> Frame:
    """The reply to a read, for simulated drives."""
    return Frame(*_native.canopen_sdo_value(node, index, sub, data))


def sdo_written(node: int, index: int, sub: int = 0) -> Frame:
    """The reply to a write, for simulated drives."""
    return Frame(*_native.canopen_sdo_written(node, index, sub))


def sdo_abort(node: int, index: int, sub: int, code: int) -> Frame:
    """The reply of a drive that refuses, with an abort code of CiA 301."""
    return Frame(*_native.canopen_sdo_abort(node, index, sub, code))


def rpdo(node: int, number: int, objects: Sequence[Mapped]) -> Frame:
    """Process data to a drive, number 0 to 3; the objects must be mapped like this in the drive."""
    return Frame(*_native.canopen_pdo(True, node, number, list(objects)))


def tpdo(node: int, number: int, objects: Sequence[Mapped]) -> Frame:
    """Process data from a drive, for simulated drives."""
    return Frame(*_native.canopen_pdo(False, node, number, list(objects)))


def decode(frame: Frame) -> Dict[str, Any]:
    """What one frame says by itself, with the names of ``motionctl decode --json``.

    It knows of no request, and of no mapping of a PDO: use :class:`motion_board.Decoder` for a conversation.
    """
    decoder = _native.FrameDecoder("canopen", None, 10.0)
    return decoder.hear(*frame, None)
