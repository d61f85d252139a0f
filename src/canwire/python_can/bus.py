"""A python-can bus on a line of a shared board."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import replace
from typing import Any

import can
from can.broadcastmanager import CyclicSendTaskABC
from can.typechecking import AutoDetectedConfig, CanFilters

import canwire
from canwire import (
    CanwireError,
    ChannelStatus,
    ErrorState,
    Hub,
    Lab,
    LabBus,
    LineStatus,
    WantedMode,
)
from canwire.python_can.arguments import check_arguments, error_frames_of, state_of, timings_of
from canwire.python_can.bench import placed
from canwire.python_can.ending import OPEN_BUSES
from canwire.python_can.errors import opening, operating, operation_error
from canwire.python_can.filters import planned
from canwire.python_can.hubs import HUBS, program_name
from canwire.python_can.line import can_places, set_listening
from canwire.python_can.messages import record_of
from canwire.python_can.opened import Opened, Wish, channel_mode
from canwire.python_can.periodic import hub_task
from canwire.python_can.returning import Missed, Returning, check_reconnect

_OUTSIDE = ("slcan", "slcan-fd", "python-can")  # kinds of boards that are real adapters
_PROTOCOLS = {True: can.CanProtocol.CAN_FD, False: can.CanProtocol.CAN_FD_NON_ISO}


class CanwireBus(can.BusABC):
    """`can.Bus(interface="canwire", channel=...)`; any number of them, in any number of programs.

    `channel` is the name of a bus ("can0": an unused line on that bus, or a shared one if all are in use) or of a line
    ("HW000001:0", "usb-to-can-fd:1": always this line, shared). Other programs receive what one program sends,
    whether they share its line or not.

    `bitrate`, `data_bitrate`, `timing`: the first program on a line sets them, others ask for the same or leave them
    out (defaults: those of the bus, else 500 kbit/s, 2 Mbit/s for data). `auto_bitrate` listens to find the rate.
    Lines of one bus may have different rates; the log then contains a warning.
    `fd`: send and receive CAN FD. `fd_non_iso`: the CAN FD before ISO 11898-1:2015.
    `receive_own_messages`: receive them once they were sent, with that time, and with `is_rx` False.
    `can_filters`: applied by the hub if they fit its filters; a change while messages arrive loses none.
    `state`: BusState.PASSIVE only listens. `exclusive`: no other program may open a channel on this line.
    `error_frames`: with None, changes of the controller's state and overruns; with True, also each bus error and lost
    arbitration; with False, none. They have SocketCAN's form and pass all filters.
    `hub`: the address of its socket (default: CANWIRE_HUB, else this user's hub, else a hub in this process).
    With a lab's bus as `channel`, or its name and the lab as `hub`: a new node there, in the lab's time.
    `reconnect`: when the hub or the board is gone, wait until it is back and continue with the same settings; `recv`
    returns None at its timeout meanwhile, `send` raises CanOperationError, and `missed` counts (docs/python-can.md).
    `rx_fifo_size`, `tx_fifo_size`: the largest numbers of messages that wait here.

    `ignore_rx_error_frames`, `local_loopback`: as with SocketCAN. Any other argument is refused.
    Errors raise CanInitializationError here and CanOperationError later, with the reason in words.
    """

    def __init__(
        self,
        channel: str | LabBus = "can0",
        can_filters: CanFilters | None = None,
        *,
        bitrate: int | None = None,
        data_bitrate: int | None = None,
        timing: can.BitTiming | can.BitTimingFd | None = None,
        auto_bitrate: bool = False,
        fd: bool = False,
        fd_non_iso: bool = False,
        receive_own_messages: bool = False,
        error_frames: bool | None = None,
        state: can.BusState | str = can.BusState.ACTIVE,
        exclusive: bool = False,
        hub: str | Hub | Lab | None = None,
        reconnect: bool = False,
        rx_fifo_size: int = 32_768,
        tx_fifo_size: int = 1024,
        **others: Any,
    ) -> None:
        self._active = False
        self._returning: Returning | None = None
        self._fd = fd = fd or isinstance(timing, can.BitTimingFd)
        with opening():
            error_frames = error_frames_of(error_frames, others, _ARGUMENTS)
            check_arguments(bitrate, data_bitrate, hub, can_filters, fd=fd)
            check_reconnect(reconnect, hub)
            at = placed(channel, hub, (bitrate or None, data_bitrate or None))
            self.channel, self._held = at.name, at.held
            self._own_hub = not isinstance(at.hub, Hub)
            self._hub = at.hub if isinstance(at.hub, Hub) else HUBS.acquire(at.hub)
            try:
                self._wanted = wanted = WantedMode(
                    *at.rates,
                    *timings_of(timing),
                    fd=fd,
                    iso_fd=not fd_non_iso,
                    listen_only=state_of(state) is can.BusState.PASSIVE,
                    find_rate=auto_bitrate,
                )
                mode = channel_mode((rx_fifo_size, tx_fifo_size), receive_own_messages, error_frames, fd=fd)
                wish = Wish(at.name, at.line, wanted, mode, exclusive, error_frames is not False)
                self._use(Opened(self._hub, wish))
                self._can_protocol = _PROTOCOLS[not fd_non_iso] if fd else can.CanProtocol.CAN_20
                super().__init__(at.name, can_filters)
                self._active = True
                self._opened.begin()
                if reconnect and self._hub.address:
                    self._returning = Returning(self._opened, wish, self._renew)
                OPEN_BUSES.add(self)
                if self._own_hub:
                    self._opened.company.tell_of_private_hub()
            except BaseException:
                self._is_shutdown = True
                self._let_go()
                raise

    # receiving

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """The oldest message, or None when none comes in `timeout` seconds (None: wait without limit)."""
        try:
            message = self._ready.popleft()  # most come from here, so this replaces all of python-can's recv
        except IndexError:
            with operating():
                return (self._returning or self._receiver).receive(timeout)
        if self._receiver.watched:
            self._receiver.tell()
        return message

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        return self.recv(timeout), True

    def fileno(self) -> int:
        """Readable while there is something to receive; NotImplementedError with `reconnect`: it would change."""
        if self._returning is not None:
            return super().fileno()
        with operating():
            return self._receiver.watch()

    def _apply_filters(self, filters: CanFilters | None) -> None:
        with self._operating():
            self._filter(self._opened, filters)

    def _filter(self, opened: Opened, filters: CanFilters | None) -> None:
        opened.filter(planned(filters), self._matches_filters if filters else None, always=self._active)

    # sending

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Queue a message.

        While the queue is full, wait: `timeout` seconds (0: not at all), with None for as long as the line runs.
        Raises CanTimeoutError when the time is over; CanOperationError for a message that cannot be sent, and for
        a line that cannot: one that is bus-off or was stopped, as soon as a message that says so was received, else
        within half a second of sending.
        """
        try:
            self._sender.send(record_of(msg, fd=self._fd), timeout)
        except CanwireError as error:
            raise operation_error(error, returns=self._returning is not None) from error

    def flush_tx_buffer(self) -> None:
        """Discard messages that wait to be sent, except a frame on the wire."""
        with self._operating():
            self._line_channel.cancel()

    def _send_periodic_internal(
        self,
        msgs: Sequence[can.Message] | can.Message,
        period: float,
        duration: float | None = None,
        autostart: bool = True,
        modifier_callback: Callable[[can.Message], None] | None = None,
    ) -> CyclicSendTaskABC:
        """Send by the hub's list if possible, else by a thread of this program, which the log reports."""
        messages = [msgs] if isinstance(msgs, can.Message) else list(msgs)
        if modifier_callback is None:
            hub, channel, ticks = self._hub, self._line_channel, self._place.info.capabilities.cyclic
            name = self.channel_info
            task = hub_task(hub, channel, ticks, messages, period, duration, fd=self._fd, name=name)
            if task is not None:
                if autostart:
                    task.start()
                return task if self._returning is None else self._returning.keep(task)
        thread = super()._send_periodic_internal(messages, period, duration, autostart, modifier_callback)
        return thread if self._returning is None else self._returning.patient(thread)

    # the hub

    @property
    def missed(self) -> Missed:
        """What this bus has missed while its hub or board was away; all 0 without `reconnect`."""
        return Missed() if self._returning is None else self._returning.missed

    def _use(self, opened: Opened) -> None:
        self._opened, self._hub, self._place, self._clock = opened, opened.hub, opened.place, opened.clock
        self._line_channel, self._receiver, self._sender = opened.channel, opened.receiver, opened.sender
        self._ready, self.channel_info = opened.receiver.ready, opened.company.channel_info

    def _renew(self, opened: Opened) -> None:
        self._filter(opened, self._filters)
        opened.begin()
        self._use(opened)

    def _operating(self) -> AbstractContextManager[None]:
        return operating(returns=self._returning is not None)

    # the line

    def line_status(self) -> LineStatus:
        """The controller's state, error counters and last error, bus load, losses, and which program has control."""
        with self._operating():
            self._line_channel.check()
            return self._place.status(self._hub)

    def channel_status(self) -> ChannelStatus:
        """Counters of this bus object: messages received, lost because they were not read, sent, and discarded."""
        with self._operating():
            return self._line_channel.status()

    @property
    def hardware_timestamps(self) -> bool:
        """True if messages have time stamps of the board; False if these may be times of arrival in this process."""
        return self._place.info.capabilities.stamps.clock_hz > 0 and self._place.board.kind != "python-can"

    @property
    def timestamp_error(self) -> float:
        """The largest difference between timestamps and this computer's clock, in seconds.

        Infinite if the hub's time does not follow that clock, and for real adapters, since the delay of their messages
        on the way to this computer is unknown (docs/adapters.md).
        """
        return math.inf if self._place.board.kind in _OUTSIDE else self._clock.error_s

    @property
    def state(self) -> can.BusState:
        """PASSIVE: the line only listens. ERROR: the line is bus-off or stopped, or its adapter is gone."""
        status = self.line_status()
        if not status.running or status.state in (ErrorState.BUS_OFF, ErrorState.STOPPED):
            return can.BusState.ERROR
        passive = status.mode is not None and status.mode.listen_only
        return can.BusState.PASSIVE if passive else can.BusState.ACTIVE

    @state.setter
    def state(self, new_state: can.BusState) -> None:
        """Set the state for all programs on the line, for which this briefly needs its control; also ends bus-off."""
        wanted = state_of(new_state)
        with self._operating():
            asked = replace(self._wanted, listen_only=wanted is can.BusState.PASSIVE)
            set_listening(self._hub, self._place, asked)

    def shutdown(self) -> None:
        """Close the bus once all messages were sent, or make no progress; a second call has no effect."""
        if self._is_shutdown:
            return
        with suppress(can.CanError, CanwireError):
            super().shutdown()
        if self._returning is not None:
            self._returning.close()
        with suppress(can.CanError, CanwireError):
            self._sender.flush()
        self._receiver.close()
        self._let_go()

    def leave_to_parent(self) -> None:
        """In a fork of the process that opened this bus: each later use raises CanOperationError."""
        self._is_shutdown = True
        self._ready.clear()

    def _let_go(self) -> None:
        OPEN_BUSES.discard(self)
        for lease in (self._opened, *self._held) if hasattr(self, "_opened") else self._held:
            with suppress(CanwireError):
                lease.close()
        if self._own_hub:
            HUBS.release(self._hub)

    @staticmethod
    def _detect_available_configs() -> Sequence[AutoDetectedConfig]:
        """Every bus and every CAN line of the hub that a Bus without more arguments would use."""
        with operating(), canwire.connect(name=program_name()) as hub:
            places = can_places(hub)
        buses = dict.fromkeys(place.info.bus for place in places if place.info.bus)
        names = [*buses, *(place.address for place in places)]
        return [{"interface": "canwire", "channel": name} for name in names]


_ARGUMENTS = tuple(name for name in inspect.signature(CanwireBus).parameters if name != "others")
