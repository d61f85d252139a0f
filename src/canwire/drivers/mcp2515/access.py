"""What this driver needs of an MCP2515, wherever it is: its instructions. The model has them all as methods."""

from __future__ import annotations

from typing import Protocol


class Instructions(Protocol):
    """An MCP2515 at the other end of an SPI interface; addresses and values 0..255, buffers by number."""

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
