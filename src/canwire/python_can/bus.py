"""A python-can bus on a line of a shared board."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Sequence
from contextlib import nullcontext, suppress
from dataclasses import replace
from typing import Any

import can
from can.broadcastmanager import CyclicSendTaskABC
from can.typechecking import AutoDetectedConfig, CanFilters

import canwire
from canwire import (
    CanwireError,
    ChannelMode,
    ChannelStatus,
    ErrorState,
    EventKind,
    Hub,
    Lab,
    LabBus,
    LineStatus,
    Siblings,
    WantedMode,
)
from canwire.python_can.arguments import check_arguments, error_frames_of, state_of, timings_of
from canwire.python_can.bench import placed
from canwire.python_can.clock import clock_of
from canwire.python_can.company import Company, warn_of_conflicts
from canwire.python_can.ending import OPEN_BUSES
from canwire.python_can.errors import opening, operating, operation_error
from canwire.python_can.filters import LIST_SIZE, planned
from canwire.python_can.hubs import HUBS, program_name
from canwire.python_can.line import can_places, kept_up, line_of_channel, set_listening
from canwire.python_can.messages import record_of
from canwire.python_can.periodic import hub_task
from canwire.python_can.receiver import Receiver
from canwire.python_can.sender import Sender

_STATES = (EventKind.STATE, EventKind.OVERRUN)
_ERRORS = (*_STATES, EventKind.ERROR, EventKind.ARBITRATION_LOST)
_OUTSIDE = ("slcan", "slcan-fd", "python-can")  # kinds of boards that are real adapters
_PROTOCOLS = {True: can.CanProtocol.CAN_FD, False: can.CanProtocol.CAN_FD_NON_ISO}


class CanwireBus(can.BusABC):
    """`can.Bus(interface="canwire", channel=...)`; any number of them, in any number of programs.

    `channel` is the name of a bus ("can0": a line there of this program's own as long as there is one that nobody
    uses, else a shared one) or of a line ("HW000001:0", "usb-to-can-fd:1": that one, shared). What one program
    sends the others receive, whether they share its line or not.

    `bitrate`, `data_bitrate`, `timing`: who comes first on a line sets it, the others agree or leave it out (that of
    the bus then, else 500 kbit/s, and 2 Mbit/s for data). `auto_bitrate` listens to find it. Lines of one bus at
    different rates are allowed, and the log warns of them.
    `fd` to send and receive CAN FD, `fd_non_iso` the one before ISO.
    `receive_own_messages`: as received once they went through, with that time, and `is_rx` False.
    `can_filters`: by the hub where they fit there; changed while messages come, none is missed.
    `state`: BusState.PASSIVE only listens. `exclusive`: nobody else may open a channel on this line.
    `error_frames`: changes of the controller's state and overruns (None), with True every bus error and lost
    arbitration as well, with False nothing; all in SocketCAN's form, and past the filters.
    `hub`: the address of its socket; without it CANWIRE_HUB, else this user's usual one, else one in this process.
    A lab's bus as `channel`, or its name with the lab as `hub`: a node of its own there, in the lab's time.
    `rx_fifo_size`, `tx_fifo_size`: messages that wait here at most.

    `ignore_rx_error_frames`, `local_loopback`: as with SocketCAN. Any other argument is refused.
    Whatever is impossible raises CanInitializationError, later CanOperationError, with the reason in words.
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
        rx_fifo_size: int = 32_768,
        tx_fifo_size: int = 1024,
        **others: Any,
    ) -> None:
        self._active = False
        self._fd = fd = fd or isinstance(timing, can.BitTimingFd)
        with opening():
            error_frames = error_frames_of(error_frames, others, _ARGUMENTS)
            check_arguments(bitrate, data_bitrate, hub, can_filters, fd=fd)
            at = placed(channel, hub, (bitrate or None, data_bitrate or None))
            self.channel, self._leases = at.name, at.held  # given back at the end, the last one first
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
                self._place, started = line_of_channel(self._hub, at.line, wanted)
                place = self._place.board.id, self._place.line
                with started or nullcontext():  # once there is a channel the line goes on by itself
                    self._line_channel = self._hub.open_channel(*place, exclusive=exclusive)
                self._leases.append(self._line_channel)
                before = kept_up(self._hub, self._place, wanted)
                warn_of_conflicts(self._hub, self._place.info.bus)
                self._line_channel.set_up(
                    ChannelMode(
                        rx_fifo_size,
                        tx_fifo_size,
                        siblings=Siblings.OTHERS_AND_OWN if receive_own_messages else Siblings.OTHERS,
                        events=_ERRORS if error_frames else _STATES,
                        filter_size=LIST_SIZE,
                        fd=fd,
                        kin="python-can",
                    )
                )
                self._clock = clock_of(self._hub)
                self._company = Company(self._hub, self._place, str(at.name))
                self.channel_info = self._company.channel_info
                self._receiver = Receiver(
                    self._line_channel,
                    self._clock,
                    at.name,
                    error_frames is not False,
                    self._company.heard_of,
                )
                self._ready = self._receiver.ready
                self._sender = Sender(self._line_channel, self._receiver, self._company)
                self._can_protocol = _PROTOCOLS[not fd_non_iso] if fd else can.CanProtocol.CAN_20
                super().__init__(at.name, can_filters)
                self._active = True
                self._receiver.begin(before, self._line_channel.activate())
                OPEN_BUSES.add(self)
                if self._own_hub:
                    self._company.tell_of_private_hub()
            except BaseException:
                self._is_shutdown = True
                self._let_go()
                raise

    # receiving

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """The oldest message, or None when none comes in `timeout` seconds (None: wait for ever)."""
        try:
            message = self._ready.popleft()  # most come from here, so this replaces all of python-can's recv
        except IndexError:
            with operating():
                return self._receiver.receive(timeout)
        if self._receiver.watched:
            self._receiver.tell()
        return message

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        return self.recv(timeout), True

    def fileno(self) -> int:
        """Readable while there is something to receive."""
        with operating():
            return self._receiver.watch()

    def _apply_filters(self, filters: CanFilters | None) -> None:
        plan = planned(filters)
        with operating():
            plan.apply(self._line_channel)
        if self._active or not plan.exact:
            self._receiver.keep(self._matches_filters if filters else None, exact=plan.exact)

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
            raise operation_error(error) from error

    def flush_tx_buffer(self) -> None:
        """Give up what waits to be sent, but for a frame on the wire."""
        with operating():
            self._line_channel.cancel()

    def _send_periodic_internal(
        self,
        msgs: Sequence[can.Message] | can.Message,
        period: float,
        duration: float | None = None,
        autostart: bool = True,
        modifier_callback: Callable[[can.Message], None] | None = None,
    ) -> CyclicSendTaskABC:
        """By the hub where that can be, else by a thread of this program, which the log tells."""
        messages = [msgs] if isinstance(msgs, can.Message) else list(msgs)
        if modifier_callback is None:
            hub, channel, ticks = self._hub, self._line_channel, self._place.info.capabilities.cyclic
            name = self.channel_info
            task = hub_task(hub, channel, ticks, messages, period, duration, fd=self._fd, name=name)
            if task is not None:
                if autostart:
                    task.start()
                return task
        return super()._send_periodic_internal(messages, period, duration, autostart, modifier_callback)

    # the line

    def line_status(self) -> LineStatus:
        """The controller's state, error counters and last error, the bus load, losses, and who holds what."""
        with operating():
            self._line_channel.check()
            return self._place.status(self._hub)

    def channel_status(self) -> ChannelStatus:
        """This bus's own counters: what came, what was lost because it was not read, what was sent and given up."""
        with operating():
            return self._line_channel.status()

    @property
    def hardware_timestamps(self) -> bool:
        """Messages have the time that the board took; False where that may be the time of their arrival here."""
        return self._place.info.capabilities.stamps.clock_hz > 0 and self._place.board.kind != "python-can"

    @property
    def timestamp_error(self) -> float:
        """How far timestamps are off this computer's clock at most, in seconds.

        Infinite where time runs otherwise, and for real adapters: how long their messages are on their way to this
        computer nobody can tell (docs/adapters.md).
        """
        return math.inf if self._place.board.kind in _OUTSIDE else self._clock.error_s

    @property
    def state(self) -> can.BusState:
        """PASSIVE only listens; ERROR is bus-off, stopped by somebody, or an adapter that is gone."""
        status = self.line_status()
        if not status.running or status.state in (ErrorState.BUS_OFF, ErrorState.STOPPED):
            return can.BusState.ERROR
        passive = status.mode is not None and status.mode.listen_only
        return can.BusState.PASSIVE if passive else can.BusState.ACTIVE

    @state.setter
    def state(self, new_state: can.BusState) -> None:
        """For everybody on the line, whose control it needs for a moment; also begins again after bus-off, without."""
        wanted = state_of(new_state)
        with operating():
            asked = replace(self._wanted, listen_only=wanted is can.BusState.PASSIVE)
            set_listening(self._hub, self._place, asked)

    def shutdown(self) -> None:
        """Once what was sent has gone out, or gets no further; a second time does nothing."""
        if self._is_shutdown:
            return
        with suppress(can.CanError, CanwireError):
            super().shutdown()
        with suppress(can.CanError, CanwireError):
            self._sender.flush()
        self._receiver.close()
        self._let_go()

    def leave_to_parent(self) -> None:
        """In a fork of the process that opened it: every use raises CanOperationError from now on."""
        self._is_shutdown = True
        self._ready.clear()

    def _let_go(self) -> None:
        OPEN_BUSES.discard(self)
        for lease in reversed(self._leases):
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
