"""A handle's channel at the hub: it turns records into events, and messages into records. A caller holds `lock`, except
for `send` and `drain`, which acquire it. Source: CANDRV manual, 7.3, 7.4, 8.23.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

from canwire import CONFIRM, CONFIRM_LOAD, CanwireError, ChannelMode, EventKind, FilterMode, Siblings
from canwire.candrv.constants import Win32Error
from canwire.candrv.device.state import KIN
from canwire.candrv.errors import CandrvError, translated
from canwire.candrv.handle.elsewhere import until_known
from canwire.candrv.handle.receiving import EVENTS, RECORD, Key, Receiver, Ticket
from canwire.candrv.handle.waiting import WaitingRoom, timed_out

if TYPE_CHECKING:
    from canwire import HubChannel, LineStatus
    from canwire.candrv.device.device import Device
    from canwire.candrv.event_queue import EventQueue

LEAST_RING = 4096  # records that the hub keeps until a call of the handle handles them
OUTCOMES = 64  # records for the outcome of messages, on a handle without a receive channel
LINGER_S = 0.25  # a closing handle discards its unsent messages after this time without progress
_SLICE_S = 0.005
_TRIES = 20  # attempts to take back a message that is on the wire


class Sending(NamedTuple):
    """Numbers of messages of a handle: `waiting` for the bus, `sent` on the bus, `given_up` (aborted)."""

    waiting: int
    sent: int
    given_up: int


class Channel:
    """`queue` None: the handle does not read. In single message mode the controller has one message at a time."""

    def __init__(self, device: Device, queue: EventQueue | None, *, write: bool) -> None:
        settings = device.settings
        self._device = device
        self._hub = device.hub
        self._single = not settings.send_buffer_mode
        self._asks = write and (queue is not None or self._single)  # it wants the outcome of each message
        self._counts_loaded = not settings.sent_on_wire
        self._register: Ticket | None = None  # with the controller, in single message mode
        self._stopped = False
        self._short_of_room = 0  # threads that wait for room in the send buffer
        self.room = WaitingRoom(device.hub)
        self.lock = self.room.lock
        self._channel: HubChannel | None = None
        try:
            transmit = 0 if not write else 1 if self._single else settings.send_buffer_size
            began = self._open(queue, transmit) if queue is not None or write else device.status()
            self.receiver = Receiver(
                queue,
                look=device.state,
                align=settings.align,
                tells_sent=settings.transmitted_events,
                level=began.state,
            )
        except BaseException:
            self.close()
            raise

    def _open(self, queue: EventQueue | None, transmit: int) -> LineStatus:
        """Open the channel; returns the line's status at the moment when the channel began to receive changes."""
        reads = queue is not None
        size = max(LEAST_RING, 2 * queue.capacity) if queue is not None else OUTCOMES
        mode = ChannelMode(
            size,
            transmit,
            exact=True,
            filter_mode=FilterMode.PASS if reads else FilterMode.LOCK,
            filter_size=0,
            siblings=Siblings.AS_BUS,
            events=EVENTS if reads else (int(EventKind.CHANGED),),
            frames=reads or self._asks,  # if False, no frame of the bus is delivered
            fd=False,
            confirms=True,
            kin=KIN,
        )
        channel = self._hub.open_channel(self._device.board.id, self._device.number)
        try:
            channel.set_up(mode)
            self._end = channel.reading
            self.reading = self._end.ring
            if transmit:
                self.writing = channel.writing.ring
            self._end.assign(self.room.event)
            began = channel.activate()
        except BaseException:
            channel.close()
            raise
        self._channel = channel
        return began

    # in

    def take(self) -> None:
        """Handle the records that have arrived, and wake the threads that wait for them."""
        self.receiver.take(self._end)
        self.room.wake()

    def look(self) -> None:
        """Handle the records that have arrived, if there are any."""
        if self.reading.fill():
            self.take()

    def still_none(self) -> int:
        """0 events, as long as any may come; raises what ended the channel. The caller holds the lock."""
        with translated():
            return int(self._until(lambda: False, self.room.deadline(0)))

    def until(self, ready: Callable[[], bool], timeout: float | None) -> bool:
        """Handle records until ready(), `timeout` seconds at most; raises the error that ended the channel."""
        return self._until(ready, self.room.deadline(timeout))

    def _until(self, ready: Callable[[], bool], deadline: int | None) -> bool:
        def looked() -> bool:
            if self._stopped:
                raise CandrvError(Win32Error.ERROR_OPERATION_ABORTED, f"{self._device.name} was closed")
            if self.reading.fill():
                self.receiver.take(self._end)
            if ready():
                return True
            self._opened().check()
            return False

        return self.room.until(looked, deadline, self._arm)

    def _arm(self) -> None:
        self._end.touched()

    # out

    def send(self, key: Key, timeout: float | None, *, virtualize: bool) -> None:
        """Queue a message; in single message mode wait until it counts as sent.

        Raises ERROR_TIMEOUT: then the message is not sent, unless it was on the wire during all of that time.
        """
        with self.lock:
            if self._stopped:
                raise CandrvError(Win32Error.ERROR_INVALID_HANDLE, f"{self._device.name} was closed")
            self._opened().check()
            deadline = self.room.deadline(timeout)
            if self._single:
                self._send_single(key, deadline, virtualize)
                return
            if not self.writing.free():
                self._await_room(deadline)
            self._put(key, virtualize)

    def _await_room(self, deadline: int | None) -> None:
        end = self._opened().writing
        if not self._short_of_room:
            end.assign(self.room.event)
        self._short_of_room += 1

        def arm() -> None:
            self._arm()
            end.touched()

        def free() -> bool:
            if self._stopped:
                raise CandrvError(Win32Error.ERROR_OPERATION_ABORTED, f"{self._device.name} was closed")
            if self.writing.free():
                return True
            self._opened().check()
            return False

        try:
            found = self.room.until(free, deadline, arm)
        finally:
            self._short_of_room -= 1
            if not self._short_of_room and not self._stopped:
                end.assign(None)
        if not found:
            capacity = self.writing.capacity
            raise timed_out(self._opened(), self._device.name, f"send buffer full, {capacity} messages wait")

    def _send_single(self, key: Key, deadline: int | None, virtualize: bool) -> None:
        if not self._until(self._register_is_free, deadline):
            raise timed_out(self._opened(), self._device.name, "the controller still has another message")
        ticket = self._put(key, virtualize)
        assert ticket is not None
        self._register = ticket
        try:
            if deadline is None and self._hub.copies and not self._hub.timed:
                until_known(ticket, self.receiver, self._opened(), self.until, self.look)
            elif not self._until(lambda: ticket.done, deadline):
                self._take_back(ticket)
        finally:
            self._register = None
            self.room.wake()
        if ticket.aborted:
            raise CandrvError(
                Win32Error.ERROR_OPERATION_ABORTED, f"{self._device.name} the message was aborted"
            )

    def _register_is_free(self) -> bool:
        """No thread uses the register, and the previous message has left it (7.4), also if it counted as sent."""
        if self._register is not None:
            return False
        if self.receiver.tickets and not self._opened().status().pending:
            self.look()
            self.receiver.tickets.clear()  # their outcome was lost in a full channel
        return not self.receiver.tickets

    def _take_back(self, ticket: Ticket) -> None:
        """After a timeout: make sure that a message that is not sent is not sent later."""
        if self._counts_loaded:  # even with a timeout of 0 the hub may give it to the controller first
            self._opened().status()
            waited = self._purge()
            self.look()
            self._forget(waited)
        for _ in range(0 if ticket.done else _TRIES):
            self.abort()
            if ticket.done or self._until(lambda: ticket.done, self.room.deadline(0.001)):
                break
        if not ticket.done or ticket.aborted:
            raise timed_out(self._opened(), self._device.name, "the message was not sent")

    def _put(self, key: Key, virtualize: bool) -> Ticket | None:
        flags, ticket = 0, None
        if self._asks:
            flags |= CONFIRM | (CONFIRM_LOAD if self._counts_loaded else 0)
            ticket = Ticket(key, counts_loaded=self._counts_loaded)
            self.receiver.tickets.append(ticket)
        self.writing.put_bytes(RECORD.pack(0, key.identifier, key.info | flags, key.data))
        if virtualize:
            self._opened().pass_on(RECORD.pack(0, key.identifier, key.info, key.data))
        return ticket

    def abort(self) -> int:
        """Abort the messages that wait; returns how many were aborted immediately.

        A message on the wire continues, and is aborted if it fails. The hub confirms each message that the controller
        had; the others, which were queued last, are not confirmed and therefore counted separately.
        """
        waited = self._purge()
        count = waited + self._opened().cancel()
        self.take()
        self._forget(waited)
        return count

    def _purge(self) -> int:
        """Abort the messages that the controller does not have; returns how many. The caller reports them."""
        return self._opened().cancel(loaded=False)

    def _forget(self, waited: int) -> None:
        if self._asks:
            self.receiver.gave_up(waited, self._hub.now_ns())
        self.room.wake()

    def sending(self) -> Sending:
        """The outcome of the messages so far; zeros for a handle without a channel."""
        if self._channel is None:
            return Sending(0, 0, 0)
        with translated():
            status = self._channel.status()
        return Sending(status.pending, status.delivered, status.aborted)

    # the end

    def stop(self) -> None:
        """End all waiting calls."""
        self._stopped = True
        self.room.wake()

    def drain(self) -> None:
        """After `stop`: wait until all messages are sent, while there is progress."""
        if self._channel is None or not self._channel.status().pending or not self._device.sends():
            return
        left, deadline = self._channel.status().pending, self.room.deadline(LINGER_S)
        while left:
            with self.lock:
                self.room.until(lambda: False, self.room.deadline(_SLICE_S), lambda: None)
            now = self._channel.status().pending
            if now < left:
                left, deadline = now, self.room.deadline(LINGER_S)
            elif self.room.passed(deadline):
                return

    def close(self) -> None:
        """Close the channel; a second call does nothing."""
        self._stopped = True
        if self._channel is not None:
            with suppress(CanwireError):
                self._channel.close()
        self.room.close()

    def _opened(self) -> HubChannel:
        assert self._channel is not None
        return self._channel
