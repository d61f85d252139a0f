"""The driver's part in fault confinement: errors, states, bus-off.

The chip recovers from bus-off by itself after 128 times 11 recessive bits, but a line stays bus-off until a program
restarts it, whatever its controller (G-11, FS-59). So the driver gives the chip nothing to send during these bits,
and puts it into configuration mode once it has recovered; for this, INT must be served between two frames. After a
`restart` during the wait the chip takes part once the wait is over; after a later `restart`, within 11 bits. `start`
does not wait for the 128 sequences, with this chip as with any other.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.chips.mcp2515 import register_map as m
from canwire.drivers.driver import Counters
from canwire.drivers.mcp2515.access import Instructions
from canwire.drivers.mcp2515.sending import Sender
from canwire.values.event import ErrorKind, ErrorState, EventKind

if TYPE_CHECKING:
    from canwire.chips.host import Host

_PASSIVE = 128  # TEC from which on a sender is error passive


class Confined(Sender):
    """The fault confinement that the chip reports. The controller stays bus-off until `restart` or `start`."""

    def __init__(self, host: Host | None, access: Instructions, now: Callable[[], int]) -> None:
        super().__init__(host, access, now)
        self._dozing = False  # sleep was asked for
        self._off = self._returning = False  # bus-off until a restart; a restart was requested
        self._tec = self._rec = 0  # as of the last error

    def _reset(self) -> None:
        """Enter configuration mode immediately."""
        raise NotImplementedError

    def _operate(self) -> None:
        """Enter the requested mode, unless bus-off."""
        raise NotImplementedError

    def _awake(self) -> None:
        """The chip is neither asleep nor about to sleep."""
        raise NotImplementedError

    def restart(self, at_ns: int) -> None:
        """Recover from bus-off: 128 times 11 recessive bits after the controller went bus-off."""
        if self._off and self._read(m.CANSTAT) >> m.REQOP_SHIFT == m.CONFIGURATION:
            self._back()
            self._operate()
        else:
            self._returning = self._off

    def counters(self) -> Counters:
        flags = self._read(m.EFLG)
        state = self._state_now(flags)
        tec = 256 if state is ErrorState.BUS_OFF else self._read(m.TEC)
        return self.counted(tec, self._read(m.REC), state)

    def _state_now(self, flags: int) -> ErrorState:
        if not self.running:
            return ErrorState.STOPPED
        return ErrorState.BUS_OFF if self._off else _state_of(flags)

    def _error(self) -> None:
        self.bus_error(ErrorKind.OTHER, transmitting=self._failed())

    def _failed(self) -> bool:
        """True if the error was in a frame of this chip: TXERR has just been set, or the counters suggest it.

        They count every error of a sender's, but the missing acknowledgement of an error-passive one.
        """
        tec, rec = self._tec, self._rec
        self._tec, self._rec = self._read(m.TEC), self._read(m.REC)
        again = self._tec > tec or (tec >= _PASSIVE and self._rec <= rec)
        sends = False
        for buffer in self._buffers:
            if buffer.in_chip and self._read(buffer.control) & m.TX_TXERR and (again or not buffer.failed):
                sends = buffer.failed = True
                if buffer.box.abort_on_error and not buffer.given_up:
                    buffer.given_up = True
                    self._chip.modify(buffer.control, m.TX_TXREQ, 0)
        return sends

    def _error_flags(self) -> None:
        """Handle ERRIF: overflows, and changes of the error state."""
        flags = self._read(m.EFLG)
        if flags & m.EFLG_OVERFLOWS:
            self._chip.modify(m.EFLG, m.EFLG_OVERFLOWS, 0)
        self._chip.modify(m.CANINTF, m.INT_ERR, 0)
        self._tell_overflows(flags)
        self._state_changed(flags)

    def _tell_overflows(self, flags: int) -> None:
        """One event for each receive buffer that could not take a frame."""
        for flag in (m.EFLG_RX0OVR, m.EFLG_RX1OVR):
            if flags & flag:
                self.tell(EventKind.OVERRUN)

    def _state_changed(self, flags: int) -> None:
        state = _state_of(flags)
        if self._off:
            if state is not ErrorState.BUS_OFF:
                self._recovered()
        elif state is not self._state:
            self._state = state
            if state is ErrorState.BUS_OFF:
                self._go_off()
            else:
                self.tell(EventKind.STATE)

    def _go_off(self) -> None:
        """Bus-off: nothing is to be sent when the chip has recovered; frames stay in the mailboxes."""
        self._off, self._returning = True, False
        self._transmits = False
        self.tell(EventKind.STATE)
        if self._dozing:
            self._awake()
        self._review()
        self._take_back()

    def _recovered(self) -> None:
        """128 times 11 recessive bits have passed in bus-off."""
        if self._returning:
            self._back()
            self._transmits = not self.listen_only
            self._send_all()
        else:
            self._reset()

    def _back(self) -> None:
        self._off = self._returning = False
        self._state = ErrorState.ERROR_ACTIVE
        self.tell(EventKind.STATE)


def _state_of(flags: int) -> ErrorState:
    """The error state in EFLG."""
    if flags & m.EFLG_TXBO:
        return ErrorState.BUS_OFF
    if flags & (m.EFLG_TXEP | m.EFLG_RXEP):
        return ErrorState.ERROR_PASSIVE
    return ErrorState.ERROR_WARNING if flags & m.EFLG_EWARN else ErrorState.ERROR_ACTIVE
