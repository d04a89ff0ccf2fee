"""A CAN frame."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["Frame"]


class Frame(NamedTuple):
    """A classic CAN frame: ``python-can`` takes it as ``can.Message(arbitration_id=f.id, data=f.data, is_extended_id=f.extended)``."""

    id: int
    """Identifier, 11 bits, or 29 where :attr:`extended`."""
    data: bytes = b""
    """0 to 8 bytes."""
    extended: bool = False
    """Whether the identifier has 29 bits."""
    remote: bool = False
    """Whether it asks for data and carries none."""

    def __str__(self) -> str:
        """Identifier and data in hexadecimal digits."""
        digits = 8 if self.extended else 3
        return " ".join([f"{self.id:0{digits}X}", *(f"{byte:02X}" for byte in self.data)])
