"""A CAN frame."""

from __future__ import annotations

from typing import NamedTuple

from .arguments import BytesLike, octets, whole
from .errors import CodecError

__all__ = ["Frame"]


class _Fields(NamedTuple):
    id: int
    data: bytes
    extended: bool
    remote: bool


class Frame(_Fields):
    """A classic CAN frame: ``python-can`` takes it as ``can.Message(arbitration_id=f.id, data=f.data, is_extended_id=f.extended)``.

    ``id``: identifier, 11 bits, or 29 where ``extended``. ``data``: 0 to 8 bytes, from anything that holds bytes, as the ``bytearray``
    of a ``can.Message``. ``remote``: it asks for data and carries none.
    """

    __slots__ = ()

    def __new__(cls, id: int, data: BytesLike = b"", extended: bool = False, remote: bool = False) -> "Frame":
        """With the data as ``bytes``, which do not change behind the frame."""
        return super().__new__(cls, id, octets("data", data), extended, remote)

    def __str__(self) -> str:
        """Identifier and data in hexadecimal digits."""
        digits = 8 if self.extended else 3
        return " ".join([f"{self.id:0{digits}X}", *(f"{byte:02X}" for byte in self.data)])


def identifier(frame: Frame) -> int:
    """The identifier, a number that one can be."""
    return whole("id", frame.id, 0, 0x1FFF_FFFF if frame.extended else 0x7FF, CodecError)
