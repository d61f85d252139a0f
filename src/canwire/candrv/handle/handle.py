"""An open handle on a device: messages out, events in, and the settings that are its own.

Any thread may use it, many at once; close it while others wait, and they leave with ERROR_OPERATION_ABORTED. The
package has no thread: whoever calls moves what has come from the channel into the event queue, which is then as if a
service thread had done so when it came. Source: CANDRV manual, chapters 7 and 8.
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
    """What `candrv.open` and CreateFile give. Every failure is a CandrvError with Win32's code.

    A handle opened with neither `read` nor `write` looks at the device and sets it up. As a Python text stream,
    `print("731 0 4 11 22 33 44", file=handle)` sends a message; iterating gives events.
    """

    def __init__(self, device: Device, *, read: bool = True, write: bool = True, share: int = 3) -> None:
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
        """The next event; waits as the read timeout says."""
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
        """The next event as ReadFile gives it; one longer than `size` stays, and raises ERROR_INSUFFICIENT_BUFFER."""
        queue = self._queue if self._queue is not None else self._no_read()
        channel = self._channel
        with channel.lock:
            self._look(channel)
            event = queue.first()
            if event is None:
                self._await(channel)
                event = queue.first()
            assert event is not None
            text = format_event(event)
            if size is not None and len(text) > size:
                raise CandrvError(
                    Win32Error.ERROR_INSUFFICIENT_BUFFER, f"the event takes {len(text)} bytes, not {size}"
                )
            queue.pop()
        return text

    def wait_comm_event(self, timeout: float | None = None) -> int:
        """The type of the next event, which stays; waits without regard to the timeouts.

        `timeout` in seconds is ours (None: for ever, as the manual has it); raises ERROR_TIMEOUT after it.
        """
        queue = self._queue if self._queue is not None else self._no_read()
        channel = self._channel
        with channel.lock:
            self._look(channel)
            if not queue.peek():
                self._await(channel, timeout, by_timeouts=False)
            return queue.peek()

    def __iter__(self) -> Iterator[Event]:
        """Events until none comes within the read timeout, or the handle is closed."""
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
        """Events in the queue now; raises what ended the handle, such as a hub that is lost, once there are none."""
        queue = self._queue if self._queue is not None else self._no_read()
        with self._channel.lock:
            self._look(self._channel)
            return len(queue) or self._channel.still_none()

    # messages

    def write(self, text: str | bytes | bytearray | memoryview) -> int:
        """WriteFile: messages as text, one, several or a part of one; returns how much of it was used: all of it.

        Each thread's parts are put together by themselves. Raises PartialWrite for text that is no message, of
        which nothing is sent, and when time runs out: then the message in question is to be written again.
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
        """Send one message, as IOCTL_CAN_WRITE_TRANSMIT_DATA does. `identifier` lies as Align says."""
        self._check_writable()
        message = Message(identifier, int(rtr), len(data) if dlc is None else dlc, data)
        with translated():
            self._writer.send(message, fmt)

    def flush(self) -> None:
        """For Python's text streams: nothing is kept back here."""

    def abort(self) -> int:
        """CANBUS_CMD_ABORT_TRANSMISSION: take back all that waits, repeat nothing; how many were given up at once."""
        self._check_writable()
        with translated(), self._channel.lock:
            return self._channel.abort()

    @property
    def sending(self) -> Sending:
        """How many messages wait for the bus, have been on it, were given up: as the hub counts them."""
        self._check_writable()
        return self._channel.sending()

    # settings of the handle

    @property
    def timeouts(self) -> COMMTIMEOUTS:
        """SetCommTimeouts, GetCommTimeouts: milliseconds, 0 at once, INFINITE for ever. A copy: assign it back."""
        self.check()
        return COMMTIMEOUTS.unpack(self._timeouts.pack())

    @timeouts.setter
    def timeouts(self, timeouts: COMMTIMEOUTS) -> None:
        self.check()
        self._timeouts = self._writer.timeouts = COMMTIMEOUTS.unpack(timeouts.pack())

    @property
    def mask(self) -> int:
        """SetCommMask, GetCommMask: the CanbusEvents that are recorded."""
        queue = self._queue if self._queue is not None else self._no_read()
        self.check()
        return queue.mask

    @mask.setter
    def mask(self, mask: int) -> None:
        queue = self._queue if self._queue is not None else self._no_read()
        with translated(), self._channel.lock:
            self._look(self._channel)  # what came before is judged by the mask before
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
        """Lines of text, an event each; what is written to it goes to WriteFile. Closing it closes the handle."""
        self.check()
        return EventStream(self)

    def close(self) -> None:
        """Give back the channels; who waits leaves with ERROR_OPERATION_ABORTED. A second time does nothing.

        Messages in the send buffer still go out, as long as there is progress: what has waited for a quarter of a
        second without any is given up.
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
        """Take in what has come. The caller holds the lock."""
        if self._closed:
            self.check()
        if channel.reading.fill():
            channel.take()

    def _await(self, channel: Channel, timeout: float | None = None, *, by_timeouts: bool = True) -> None:
        """Until an event is in the queue; the caller holds the lock."""
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
