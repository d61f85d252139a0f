"""The instructions of an MCP2515, real or simulated, that this driver uses. The model has a method for each."""

from __future__ import annotations

from typing import Protocol


class Instructions(Protocol):
    """An MCP2515 on an SPI interface. Addresses and values are 0..255; buffers are numbered."""

    def reset(self) -> None:
        """RESET."""

    def read(self, address: int) -> int:
        """READ of one register."""

    def write(self, address: int, value: int) -> None:
        """WRITE of one register."""

    def modify(self, address: int, mask: int, value: int) -> None:
        """BIT MODIFY."""

    def load_buffer(self, buffer: int, data: bytes) -> None:
        """LOAD TX BUFFER from SIDH on."""

    def read_buffer(self, buffer: int) -> bytes:
        """READ RX BUFFER: 13 bytes from SIDH on; clears RXnIF."""

    def request_to_send(self, buffers: int) -> None:
        """RTS for the transmit buffers whose bits are set."""
