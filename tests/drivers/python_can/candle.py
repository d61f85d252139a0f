"""A candleLight that is not there: what pyusb's device does, by gs_usb's protocol; used by tests alone."""

from __future__ import annotations

import errno
import queue
import struct
import threading
from typing import Any

CLOCK_HZ = 80_000_000
_LIMITS = (1, 256, 1, 128, 128, 1, 512, 1)
LISTEN_ONLY, STAMPS, FD, DATA_LIMITS, BUS_ERRORS = 1, 1 << 4, 1 << 8, 1 << 10, 1 << 12


class Candle:
    """Echoes what it is given as the bus takes it (unless `acknowledged` is False); `say` is what its bus says."""

    idVendor, idProduct, bus, address = 0x1D50, 0x606F, 1, 5  # noqa: N815 - pyusb's names

    def __init__(self, serial: str = "C0FFEE", *, fd: bool = True, channels: int = 1) -> None:
        self.serial_number, self.product = serial, "candleLight FD"
        self.features = LISTEN_ONLY | STAMPS | BUS_ERRORS | (FD | DATA_LIMITS if fd else 0)
        self.channels = channels
        self.requests: list[tuple[int, int, bytes]] = []
        self.written: list[bytes] = []
        self.was_written = threading.Event()
        self.acknowledged = True
        self.unplugged = False
        self.kernel = False
        self.refusal: OSError | None = None
        self.stamp_us = (1 << 32) - 500  # it wraps soon
        self._packets: queue.Queue[bytes | None] = queue.Queue()

    def is_kernel_driver_active(self, interface: int) -> bool:
        return self.kernel

    def detach_kernel_driver(self, interface: int) -> None:
        self.kernel = False

    def ctrl_transfer(self, kind: int, request: int, value: int, index: int, data: Any) -> Any:
        self._there()
        if self.refusal is not None:
            raise self.refusal
        if kind == 0x41:
            self.requests.append((request, value, bytes(data)))
            return len(data)
        answers = {
            4: struct.pack("<10I", self.features, CLOCK_HZ, *_LIMITS),
            5: bytes([0, 0, 0, self.channels - 1]) + struct.pack("<2I", 2, 1),
            11: struct.pack("<10I", self.features, CLOCK_HZ, *_LIMITS)
            + struct.pack("<8I", 1, 32, 1, 16, 16, 1, 32, 1),
        }
        return answers[request]

    def write(self, endpoint: int, data: bytes, timeout: int = 0) -> int:
        self._there()
        self.written.append(bytes(data))
        self.was_written.set()
        if self.acknowledged:
            self.echo(bytes(data))
        return len(data)

    def echo(self, data: bytes) -> None:
        """The bus has taken it."""
        self._packets.put(data + self._stamp())

    def say(
        self, id: int, data: bytes = b"", *, flags: int = 0, dlc: int | None = None, channel: int = 0
    ) -> None:
        """A frame from the bus."""
        code = len(data) if dlc is None else dlc
        head = struct.pack("<IIBBBB", 0xFFFFFFFF, id, code, channel, flags, 0)
        self._packets.put(head + data.ljust(64 if flags & 2 else 8, b"\0") + self._stamp())

    def pull(self) -> None:
        """Out of its socket."""
        self.unplugged = True
        self._packets.put(None)

    def read(self, endpoint: int, length: int, timeout: int = 0) -> bytes:
        self._there()
        try:
            packet = self._packets.get(timeout=timeout / 1000)
        except queue.Empty:
            raise OSError(errno.ETIMEDOUT, "Operation timed out") from None
        self._there()
        assert packet is not None
        assert len(packet) <= length
        return packet

    def _stamp(self) -> bytes:
        self.stamp_us += 1000
        return struct.pack("<I", self.stamp_us & 0xFFFFFFFF)

    def _there(self) -> None:
        if self.unplugged:
            raise OSError(errno.ENODEV, "No such device (it may have been disconnected)")
