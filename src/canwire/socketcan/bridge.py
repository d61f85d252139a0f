"""Connects a hub's line and a CAN interface of the kernel: each side sends the frames that the other one receives."""

from __future__ import annotations

import errno
import socket
import struct
from collections import deque
from contextlib import suppress
from typing import TYPE_CHECKING

from canwire import CanwireError, HubError
from canwire.socketcan.constants import (
    AF_CAN,
    CAN_RAW,
    CAN_RAW_FD_FRAMES,
    CANFD_MTU,
    SOL_CAN_RAW,
)
from canwire.socketcan.loop import READABLE, Loop
from canwire.socketcan.wire import (
    HEADER_SIZE,
    frames_received,
    numpy_module,
    records_to_send,
    sent_dtype,
    sound,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire import HubChannel

_AT_ONCE = 512
_MOST_WAITING = 8192  # frames for a kernel that takes none
_RETRY_S = 0.001  # a kernel's full transmit queue tells nobody when it has room
_HEAD = struct.Struct("<iI")


def kernel_socket(name: str) -> socket.socket:
    """A socket on the kernel's interface of this name; raises HubError if it does not exist."""
    try:
        made = socket.socket(AF_CAN, socket.SOCK_RAW, CAN_RAW)
    except OSError as error:
        raise HubError(
            f"this kernel has no CAN ({error.strerror}); `modprobe can_raw vcan` may help"
        ) from None
    try:
        made.bind((name,))
        with suppress(OSError):  # an old kernel: classic CAN only
            made.setsockopt(SOL_CAN_RAW, CAN_RAW_FD_FRAMES, 1)
    except OSError as error:
        made.close()
        raise HubError(f"{name}: {error.strerror}; `ip link` shows the kernel's interfaces") from None
    made.setblocking(False)
    return made


class Bridge:
    """`run` until the hub, the interface or `stop` ends it. `to_kernel`, `to_hub`, `lost` count frames."""

    def __init__(self, channel: HubChannel, kernel: socket.socket) -> None:
        self.to_kernel = self.to_hub = self.lost = 0
        self._channel = channel
        self._kernel = kernel
        self._loop = Loop()
        self._waiting: deque[bytes] = deque()
        self._retries = False
        self._failure: Exception | None = None

    def run(self) -> None:
        """Pass frames until the end; raises HubError if the hub is gone, OSError if the interface is."""
        reading, writing = self._channel.reading, self._channel.writing
        writing.threshold = _AT_ONCE // 2
        self._loop.watch(reading.descriptor.fileno(), READABLE, self._guarded(self._from_hub))
        self._loop.watch(writing.descriptor.fileno(), READABLE, self._guarded(self._has_room))
        self._loop.watch(self._kernel.fileno(), READABLE, self._guarded(self._from_kernel))
        self._guarded(self._from_hub)(0)
        try:
            self._loop.run()
        finally:
            self._loop.close()
        if self._failure is not None:
            raise self._failure

    def _guarded(self, call: Callable[[], object]) -> Callable[[int], None]:
        """Call this; an error ends the bridge."""

        def guarded(_: int) -> None:
            try:
                call()
            except (CanwireError, OSError) as error:
                self._failure = error
                self._loop.stop()

        return guarded

    # towards the kernel

    def _from_hub(self) -> None:
        end = self._channel.reading
        end.descriptor.clear()
        records = self._channel.receive_array(_AT_ONCE)
        if not len(records):
            end.ring.arm()
            return
        for row in frames_received(records, 0, 0):
            self._waiting.append(row.tobytes()[HEADER_SIZE : HEADER_SIZE + int(row["length"])])
        while len(self._waiting) > _MOST_WAITING:
            self._waiting.popleft()
            self.lost += 1
        self._flush()
        self._loop.soon(lambda: self._guarded(self._from_hub)(0))

    def _flush(self) -> None:
        while self._waiting:
            try:
                self._kernel.send(self._waiting[0])
            except OSError as error:
                if error.errno in (errno.ENOBUFS, errno.EAGAIN):
                    self._retry_later()
                    return
                if error.errno not in (errno.EINVAL, errno.EMSGSIZE):
                    raise
                self.lost += 1  # CAN FD for an interface without it
            else:
                self.to_kernel += 1
            self._waiting.popleft()

    def _retry_later(self) -> None:
        if not self._retries:
            self._retries = True
            self._loop.call_in(_RETRY_S, lambda: self._guarded(self._retry)(0))

    def _retry(self) -> None:
        self._retries = False
        self._flush()

    # towards the hub

    def _from_kernel(self) -> None:
        ring = self._channel.writing.ring
        room = min(_AT_ONCE, ring.free())
        if not room:
            self._loop.forget(self._kernel.fileno())
            ring.arm_free()
            return
        packed = bytearray()
        with suppress(BlockingIOError):
            for _ in range(room):
                frame = self._kernel.recv(CANFD_MTU)
                packed += _HEAD.pack(0, len(frame)) + frame.ljust(CANFD_MTU, b"\0")
        rows = numpy_module().frombuffer(packed, sent_dtype())
        rows = rows[sound(rows)]
        self._channel.send_array(records_to_send(rows))
        self.to_hub += len(rows)

    def _has_room(self) -> None:
        self._channel.writing.descriptor.clear()
        self._loop.watch(self._kernel.fileno(), READABLE, self._guarded(self._from_kernel))
