"""An open handle on a device: it sends messages, receives events, and has its own filter, mask and timeouts.

Several threads may use a handle at the same time. If one closes it, the calls that wait end with
ERROR_OPERATION_ABORTED. The package has no thread: the calling thread moves events from the channel into the event
queue, with the same result as a service thread. Source: CANDRV manual, chapters 7 and 8.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import TYPE_CHECKING

from canwire import CanwireError
from canwire.candrv.constants import INFINITE, FrameFormat, Win32Error
from canwire.candrv.errors import CandrvError, translated
from canwire.candrv.event_queue import Event, EventQueue
from canwire.candrv.filters import ALL_BITS, Filter
from canwire.candrv.handle.channel import Channel, Sending
from canwire.candrv.handle.controls import Controls
from canwire.candrv.handle.stream import EventStream
from canwire.candrv.handle.writing import Writer, ascii_of, seconds
from canwire.candrv.structures import CAN_ACCEPTANCE_FILTER, COMMTIMEOUTS
from canwire.candrv.text import Message, format_event

if TYPE_CHECKING:
    from types import TracebackType

    from canwire.candrv.device.device import Device


class Handle(Controls):
    """The handle that `candrv.open` returns. Each failure raises a CandrvError with a Win32 code.

    A handle opened with neither `read` nor `write` can query and configure the device. As in a Python text stream,
    `print("731 0 4 11 22 33 44", file=handle)` sends a message; iterating yields events.
    """

    def __init__(self, device: Device, *, read: bool, write: bool, share: int) -> None:
        self.device = device
        self.readable, self.writable = bool(read), bool(write)
        settings = device.settings
        self._timeouts = COMMTIMEOUTS(0, 0, INFINITE, 0, INFINITE)
        self._queue = EventQueue(settings.event_queue_size) if read else None
        self._closed = False
        with translated():
            self._share = device.hub.open_share(
                device.board.id, device.number, read=self.readable, write=self.writable, share=share
            )
            try:
                device.start()
                self._channel = Channel(device, self._queue, write=self.writable)
            except BaseException:
                device.close()
                self._share.close()
                raise
        self._writer = Writer(device, self._channel, self._timeouts)
        if self._queue is not None:
            self._channel.receiver.filter = Filter.registered(settings)
        device.debug(f"opened, read={self.readable} write={self.writable} share={share}")

    @property
    def name(self) -> str:
        return self.device.name

    @property
    def closed(self) -> bool:
        return self._closed

    # events

    def read_event(self) -> Event:
        """The next event; waits for the read timeout at most."""
        queue = self._queue if self._queue is not None else self._no_read()
        channel = self._channel
        with channel.lock:
            self._look(channel)
            event = queue.pop()
            if event is None:
                self._await(channel)
                event = queue.pop()
        assert event is not None
        return event

    def read_text(self, size: int | None = None) -> bytes:
        """The next event as ReadFile's text; one longer than `size` raises ERROR_INSUFFICIENT_BUFFER and stays."""
        queue = self._queue if self._queue is not None else self._no_read()
        channel = self._channel
        with channel.lock:
            if self._closed or channel.reading.fill():
                self._look(channel)
            event = queue.pop()
            if event is None:
                self._await(channel)
                event = queue.pop()
            assert event is not None
            text = format_event(event)
            if size is not None and len(text) > size:
                queue.put_back(event)
                why = f"the event needs {len(text)} bytes, not {size}"
                raise CandrvError(Win32Error.ERROR_INSUFFICIENT_BUFFER, why)
        return text

    def wait_comm_event(self, timeout: float | None = None) -> int:
        """The type of the next event, which stays in the queue; it ignores the handle's timeouts.

        It waits `timeout` seconds, not in the manual, and then raises ERROR_TIMEOUT; None waits without limit.
        """
        queue = self._queue if self._queue is not None else self._no_read()
        channel = self._channel
        with channel.lock:
            self._look(channel)
            if not queue.peek():
                self._await(channel, timeout, by_timeouts=False)
            return queue.peek()

    def __iter__(self) -> Iterator[Event]:
        """Yields events until none arrives within the read timeout, or the handle is closed."""
        while True:
            try:
                yield self.read_event()
            except CandrvError as error:
                over = (Win32Error.ERROR_TIMEOUT, Win32Error.ERROR_OPERATION_ABORTED)
                if error.code in over or (self._closed and error.code == Win32Error.ERROR_INVALID_HANDLE):
                    return
                raise

    @property
    def waiting(self) -> int:
        """The number of events in the queue. If there are none, raises what ended the handle, such as a lost hub."""
        queue = self._queue if self._queue is not None else self._no_read()
        with self._channel.lock:
            self._look(self._channel)
            return len(queue) or self._channel.still_none()

    # messages

    def write(self, text: str | bytes | bytearray | memoryview) -> int:
        """WriteFile: send messages as text, one, several or a part of one; returns the number of characters, all used.

        Parts are joined for each thread. Raises PartialWrite for text that is no message, which is not sent, and
        after the write timeout: write that message again.
        """
        self._check_writable()
        return self._writer.write(ascii_of(text))

    write_text = write

    def write_message(
        self,
        identifier: int,
        data: bytes = b"",
        *,
        rtr: bool | int = False,
        dlc: int | None = None,
        fmt: int = FrameFormat.DEFAULT,
    ) -> None:
        """Send one message, as IOCTL_CAN_WRITE_TRANSMIT_DATA does. `identifier` is aligned by the entry Align."""
        self._check_writable()
        message = Message(identifier, int(rtr), len(data) if dlc is None else dlc, data)
        with translated():
            self._writer.send(message, fmt)

    def flush(self) -> None:
        """Does nothing, since a handle has no buffered text; Python's text streams need this method."""

    def abort(self) -> int:
        """CANBUS_CMD_ABORT_TRANSMISSION: abort waiting messages and all repetition; returns how many it aborted."""
        self._check_writable()
        with translated(), self._channel.lock:
            return self._channel.abort()

    @property
    def sending(self) -> Sending:
        """The hub's count of messages that wait for the bus, that have been sent, and that were aborted."""
        self._check_writable()
        return self._channel.sending()

    # settings of the handle

    @property
    def timeouts(self) -> COMMTIMEOUTS:
        """The timeouts of this handle, a copy: assign it to change them. 0 ms does not wait, INFINITE has no limit."""
        self.check()
        return COMMTIMEOUTS.unpack(self._timeouts.pack())

    @timeouts.setter
    def timeouts(self, timeouts: COMMTIMEOUTS) -> None:
        self.check()
        self._timeouts = self._writer.timeouts = COMMTIMEOUTS.unpack(timeouts.pack())

    @property
    def mask(self) -> int:
        """SetCommMask, GetCommMask: the CanbusEvents that the event queue stores."""
        queue = self._queue if self._queue is not None else self._no_read()
        self.check()
        return queue.mask

    @mask.setter
    def mask(self, mask: int) -> None:
        queue = self._queue if self._queue is not None else self._no_read()
        with translated(), self._channel.lock:
            self._look(self._channel)  # the previous mask applies to earlier events
            queue.mask = mask
            self._channel.room.wake()

    @property
    def filter(self) -> CAN_ACCEPTANCE_FILTER:
        """Code and mask of this receive channel."""
        if self._queue is None:
            self._no_read()
        self.check()
        return self._channel.receiver.filter.to_structure()

    @filter.setter
    def filter(self, structure: CAN_ACCEPTANCE_FILTER) -> None:
        if self._queue is None:
            self._no_read()
        settings = self.device.settings
        with translated(), self._channel.lock:
            chosen = Filter.of(structure, settings.align, settings.mask_active)
            self._look(self._channel)
            self._channel.receiver.filter = chosen

    def accept_all(self) -> None:
        """Let every frame pass, as CanRead does."""
        self.filter = CAN_ACCEPTANCE_FILTER(0, 0 if self.device.settings.mask_active else ALL_BITS)

    # the rest

    def stream(self) -> EventStream:
        """A text file whose lines are events, and whose `write` sends messages. Closing it closes the handle."""
        self.check()
        return EventStream(self)

    def close(self) -> None:
        """Close the handle; calls that wait raise ERROR_OPERATION_ABORTED. A second call does nothing.

        Messages in the send buffer are still sent while there is progress: after a quarter of a second without
        progress they are discarded.
        """
        channel = self._channel
        with channel.lock:
            if self._closed:
                return
            self._closed = True
            channel.stop()
        try:
            with suppress(CanwireError):
                channel.drain()
        finally:
            with channel.lock:
                channel.close()
            self.device.close()
            with suppress(CanwireError):
                self._share.close()
            self.device.debug("closed")

    def __enter__(self) -> Handle:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        access = "+".join(("read",) * self.readable + ("write",) * self.writable) or "query"
        return f"<CANDRV handle on {self.name} for {access}{', closed' if self._closed else ''}>"

    # its own

    def _look(self, channel: Channel) -> None:
        """Handle what has arrived. The caller holds the lock."""
        if self._closed:
            self.check()
        if channel.reading.fill():
            channel.take()

    def _await(self, channel: Channel, timeout: float | None = None, *, by_timeouts: bool = True) -> None:
        """Wait until an event is in the queue. The caller holds the lock."""
        queue = self._queue
        if by_timeouts:
            timeout = seconds(self._timeouts.ReadTotalTimeoutConstant)
        with translated():
            if not channel.until(lambda: bool(queue), timeout):
                raise CandrvError(Win32Error.ERROR_TIMEOUT, f"{self.name} no event")

    def check(self) -> None:
        if self._closed:
            raise CandrvError(Win32Error.ERROR_INVALID_HANDLE, f"{self.name} was closed")

    def _check_writable(self) -> None:
        self.check()
        if not self.writable:
            raise CandrvError(Win32Error.ERROR_ACCESS_DENIED, f"{self.name} is not open for writing")

    def _no_read(self) -> EventQueue:
        self.check()
        raise CandrvError(Win32Error.ERROR_ACCESS_DENIED, f"{self.name} is not open for reading")
