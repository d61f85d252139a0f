"""The receiver of a LIN node, edge by edge: it finds breaks, sync fields and bytes in a changing level.

Source: LIN 2.2A 2.3.1 and 6.3; reference/lin-protocol.md sections 1, 2, 7 and 9.
"""

from __future__ import annotations

from canwire.bus.lin.node import LinNode
from canwire.timeline import NEVER
from canwire.values.lin.frame import parity_holds
from canwire.values.lin.timing import (
    BREAK_THRESHOLD_BITS,
    FIELD_BITS,
    SYNC_BYTE,
    WAKE_THRESHOLD_PS,
    bit_time_of_sync,
    follows,
)

OFF, DEAF, ASLEEP, LISTENING, IN_SYNC, IN_PID, IN_DATA = range(7)
_SLOWEST_PS, _QUICKEST_PS = 1_020_000_000, 49_000_000  # 1 to 20 kbit/s, 2 % more or less
_UNKNOWN = -1
_NO_BYTE = -1
_STOP_BIT = 9
_PATIENCE_BITS = 48  # from a break to the sync field, and from there to the identifier
_SYNC_BITS = 12


class Listener:
    """The reports of a receiver, at times in ps."""

    def broke(self, at_ps: int) -> None:
        """Called when a break ended."""
        raise NotImplementedError

    def lost(self, field: int, at_ps: int) -> None:
        """Called when the receiver lost the frame: in IN_SYNC no valid sync field came, in IN_PID or IN_DATA a stop bit
        was 0.
        """
        raise NotImplementedError

    def parity_wrong(self, pid: int, at_ps: int) -> None:
        raise NotImplementedError

    def header(self, pid: int, at_ps: int) -> None:
        raise NotImplementedError

    def octet(self, value: int, at_ps: int) -> None:
        raise NotImplementedError

    def late(self, at_ps: int) -> None:
        """Called when the time for a response is over."""
        raise NotImplementedError

    def woken(self, at_ps: int) -> None:
        raise NotImplementedError

    def rate_found(self, bit_ps: int, at_ps: int) -> None:
        raise NotImplementedError


class LinReceiver:
    """Decodes the wire for one node. `mode` is what it waits for, `bit_ps` the bit time that it assumes.

    `due_ps` is when it acts next: an attribute, because it is read at each bit of all nodes.
    """

    def __init__(self, node: LinNode, listener: Listener) -> None:
        self.mode = LISTENING
        self.bit_ps = node.bit_ps
        self.limit_ps = NEVER
        self._node = node
        self._listener = listener
        self._low_since_ps = _UNKNOWN
        self._lows: list[int] = []
        self._falls: list[int] = []
        self._bit = _NO_BYTE
        self._start_ps = 0
        self._value = 0
        self._held = False
        self._sample_ps = NEVER
        self._over_ps = NEVER
        self.due_ps = NEVER

    def follow(self, mode: int, limit_ps: int = NEVER) -> None:
        """Wait for `mode` from now on, until `limit_ps` at the latest."""
        self.mode = mode
        self.limit_ps = self.due_ps = limit_ps
        self._drop_byte()

    def await_response(self, limit_ps: int) -> None:
        """Wait for a response; the start bit of a quick slave may have begun already, behind the sample point of the
        header's last bit.
        """
        self.follow(IN_DATA, limit_ps)
        if self._low_since_ps != _UNKNOWN:
            self._begin_byte(self._low_since_ps)
            self._set_due()

    def edge(self, level: int, at_ps: int) -> None:
        """Process a change of level on the wire."""
        if level == 0:
            self._fell(at_ps)
        else:
            self._rose(at_ps)
        self._set_due()

    def act(self, level: int, at_ps: int) -> None:
        """Process the event that is due."""
        if self._over_ps <= at_ps:
            self._complete(self._over_ps)
        elif self._sample_ps <= at_ps:
            self._sample(level)
        elif self.limit_ps <= at_ps:
            self._give_up(at_ps)
        self._set_due()

    def _set_due(self) -> None:
        due_ps = self._sample_ps if self._sample_ps < self._over_ps else self._over_ps
        self.due_ps = due_ps if due_ps < self.limit_ps else self.limit_ps

    def _fell(self, at_ps: int) -> None:
        if self._over_ps != NEVER:
            self._complete(at_ps)  # a sender quicker than this node
        self._low_since_ps = at_ps
        if self._node.searching:
            self._search(at_ps)
        elif self.mode == IN_SYNC and self._node.synchronises:
            self._sync_fall(at_ps)
        elif self.mode >= IN_SYNC and self._bit == _NO_BYTE and not self._held:
            self._begin_byte(at_ps)

    def _rose(self, at_ps: int) -> None:
        low_ps = 0 if self._low_since_ps == _UNKNOWN else at_ps - self._low_since_ps
        self._low_since_ps = _UNKNOWN
        node = self._node
        if self.mode == ASLEEP:
            if low_ps > WAKE_THRESHOLD_PS:
                self._listener.woken(at_ps)
        elif node.searching:
            self._lows.append(low_ps)
        elif self.mode >= LISTENING and low_ps >= BREAK_THRESHOLD_BITS * node.bit_ps:
            self._lows = [low_ps]
            self._falls = []
            self.bit_ps = node.bit_ps
            self._listener.broke(at_ps)
            self.follow(IN_SYNC, at_ps + _PATIENCE_BITS * node.bit_ps)
        elif self._held:
            self._lose(at_ps)

    # the sync field

    def _sync_fall(self, at_ps: int) -> None:
        self._falls.append(at_ps)
        node = self._node
        if len(self._falls) == 1:
            self.limit_ps = at_ps + _SYNC_BITS * node.bit_ps
        if len(self._falls) != 5:
            return
        bit_ps = bit_time_of_sync(self._falls)
        if bit_ps is None or not follows(node.bit_ps, bit_ps):
            self._lose(at_ps)
        elif self._lows[0] < BREAK_THRESHOLD_BITS * bit_ps:
            self.follow(LISTENING)
        else:
            self._await_stop_bit(bit_ps)

    def _search(self, at_ps: int) -> None:
        """Look for a sync field: any five falls may be one, if the low pulse before them was 11 of its bits long."""
        self._falls = [*self._falls[-5:], at_ps]
        self._lows = self._lows[-5:]
        if self.mode < LISTENING or len(self._falls) < 6 or len(self._lows) < 5:
            return
        bit_ps = bit_time_of_sync(self._falls[1:])
        possible = bit_ps is not None and _QUICKEST_PS <= bit_ps <= _SLOWEST_PS
        if bit_ps is not None and possible and self._lows[0] >= BREAK_THRESHOLD_BITS * bit_ps:
            del self._falls[0]
            self._listener.broke(at_ps)
            self.follow(IN_SYNC)
            self._await_stop_bit(bit_ps)

    def _await_stop_bit(self, bit_ps: int) -> None:
        self.bit_ps = bit_ps
        self.limit_ps = NEVER
        self._start_ps = self._falls[0]
        self._bit = _STOP_BIT
        self._value = SYNC_BYTE
        self._sample_ps = self._start_ps + (2 * _STOP_BIT + 1) * bit_ps // 2

    # bytes

    def _begin_byte(self, at_ps: int) -> None:
        self._start_ps = at_ps
        self._bit = self._value = 0
        self._sample_ps = at_ps + self.bit_ps // 2

    def _sample(self, level: int) -> None:
        bit = self._bit
        if bit == 0 and level == 1:
            self._drop_byte()  # too short for a start bit
        elif bit < _STOP_BIT:
            if bit:
                self._value |= level << (bit - 1)
            self._bit += 1
            self._sample_ps = self._start_ps + (2 * bit + 3) * self.bit_ps // 2
        elif level == 1:
            self._sample_ps = NEVER
            self._over_ps = self._start_ps + FIELD_BITS * self.bit_ps
        else:
            self._drop_byte()
            self._held = True  # a break, or a stop bit that is none: its end will tell

    def _complete(self, at_ps: int) -> None:
        value, mode = self._value, self.mode
        self._drop_byte()
        if mode == IN_SYNC:
            self._synchronised(value, at_ps)
        elif mode == IN_PID:
            self._identified(value, at_ps)
        elif mode == IN_DATA:
            self._listener.octet(value, at_ps)

    def _synchronised(self, value: int, at_ps: int) -> None:
        if value != SYNC_BYTE:
            self._lose(at_ps)
            return
        if self._node.searching:
            self._listener.rate_found(self.bit_ps, at_ps)
        self.follow(IN_PID, at_ps + _PATIENCE_BITS * self.bit_ps)

    def _identified(self, pid: int, at_ps: int) -> None:
        self.follow(LISTENING)
        if parity_holds(pid):
            self._listener.header(pid, at_ps)
        else:
            self._listener.parity_wrong(pid, at_ps)

    def _give_up(self, at_ps: int) -> None:
        """End the wait at `limit_ps`: nothing more came."""
        mode = self.mode
        if mode == IN_SYNC and self._falls:
            self._lose(at_ps)
            return
        self.follow(LISTENING)
        if mode == IN_DATA:
            self._listener.late(at_ps)

    def _lose(self, at_ps: int) -> None:
        field = self.mode
        self.follow(LISTENING)
        self._listener.lost(field, at_ps)

    def _drop_byte(self) -> None:
        self._bit = _NO_BYTE
        self._held = False
        self._sample_ps = self._over_ps = NEVER
