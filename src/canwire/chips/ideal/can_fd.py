# cython: nonecheck=False
"""The ideal CAN FD controller: no registers, two mailboxes, and the fast path between bus and line.

Frames of high priority have a separate mailbox that is sent before the normal one. Received frames and
the outcomes of sent frames go to a `Host`, which the line implements.
"""

from __future__ import annotations

from canwire.bus.can import bits as can_bits
from canwire.bus.can.node import Mailbox, Node
from canwire.chips.confinement import Confinement
from canwire.chips.host import Host
from canwire.values.checks import instance
from canwire.values.controller_options import USUAL, ControllerOptions
from canwire.values.event import ErrorState, EventKind

_PASSIVE, _BUS_OFF = 2, 3
_STOPPED = int(ErrorState.STOPPED)
_ERROR = int(EventKind.ERROR)
_STATE = int(EventKind.STATE)
_ARBITRATION_LOST = int(EventKind.ARBITRATION_LOST)
RECOVERY_SEQUENCES = 128


class CanFdController(Node):
    """The controller: two mailboxes, and fault confinement."""

    def __cinit__(self, *_: object) -> None:
        """Compiled: what was never initialised has all its parts, since no access to them is checked."""
        self.host = Host.__new__(Host)
        self.confinement = Confinement.__new__(Confinement)
        self.normal = Mailbox.__new__(Mailbox)
        self.high = self.normal

    def __init__(self, host: Host) -> None:
        super().__init__()
        instance("host", host, Host)
        self.host = host
        self.confinement = Confinement()
        self.normal = Mailbox()
        self.high = Mailbox()
        self.running = False
        self.errors = 0
        self.last_error = 0
        self.frames_sent = 0

    # the host's side

    def configure(
        self,
        nominal: tuple[int, ...],
        data: tuple[int, ...] | None,
        fd: int,
        listen_only: bool,
        options: ControllerOptions = USUAL,
    ) -> None:
        """Set bit times in ps: bit, sample point, quantum, PHASE1, jump; `fd` as Node.fd; effective immediately."""
        self._interrupt()
        self.bit_ps, self.sample_ps, self.quantum_ps, self.phase1_ps, self.jump_ps = nominal
        bit, sample, quantum, _, jump = nominal if data is None else data
        self.data_bit_ps, self.data_sample_ps, self.data_quantum_ps, self.data_jump_ps = (
            bit,
            sample,
            quantum,
            jump,
        )
        self.fd = fd
        self.listen_only = listen_only
        self._take_options(options)
        for box in (self.normal, self.high):
            if box.occupied:
                can_bits.measure(box, fd)
        self._make_offer()
        self._changed()

    def counters(self) -> tuple[int, ...]:
        """TEC, REC, ErrorState, errors, arbitration losses, frames sent, frames received."""
        confinement = self.confinement
        if self.bus is not None:
            self.bus.catch_up(self)
        return (
            confinement.tec,
            confinement.rec,
            self.state(),
            self.errors,
            self.arbitration_losses,
            self.frames_sent,
            self.frames_received,
        )

    def take(self, box: Mailbox) -> None:
        """Request transmission of the frame in this mailbox, one of the two."""
        can_bits.measure(box, self.fd)
        self._make_offer()

    def abort(self, box: Mailbox, at_ns: int) -> bool:
        """Abort the frame in a mailbox; a frame that is on the wire at this moment continues, but is not repeated."""
        if not box.occupied:
            return False
        if self.contending is box and self.bus is not None and self.bus.on_wire(self):
            box.single_shot = True
            return False
        self._give_up(box, at_ns)
        return True

    def forget(self) -> None:
        """Return to the settings of a classic controller that takes part in the bus, until it is configured."""
        self.listen_only = False
        self.fd = 0
        self._take_options(USUAL)

    def start(self, at_ns: int, *, integrated: bool = False) -> None:
        """Join the bus with cleared counters: after 11 recessive bits, or immediately if `integrated`."""
        self._interrupt()
        self.confinement.reset()
        self.running = True
        self._take_state()
        self._wait(0 if integrated else 1, at_ns)
        self.on_bus = integrated
        self._changed()
        self.host.event(_STATE, 0, -1, False, at_ns, 0)
        self.host.fill(at_ns)

    def stop(self, at_ns: int) -> None:
        """Leave the bus immediately, even in the middle of a bit; frames stay in their mailboxes."""
        self._interrupt()
        self.running = False
        self.on_bus = False
        self._wait(0, at_ns)
        self._changed()
        self.host.event(_STATE, 0, -1, False, at_ns, 0)

    def restart(self, at_ns: int) -> None:
        """After bus-off, begin to wait for 128 times 11 recessive bits; in other states do nothing."""
        if self.confinement.state == _BUS_OFF and not self.waiting:
            self._interrupt()
            self._wait(RECOVERY_SEQUENCES, at_ns)
            self._changed()

    def rejoin(self, at_ns: int) -> None:
        """Join the bus after a reconnection: wait for 11 recessive bits; error counters do not change."""
        if self.running and self.confinement.state != _BUS_OFF:
            self._interrupt()
            self.on_bus = False
            self._wait(1, at_ns)
            self._changed()

    def state(self) -> int:
        """The present ErrorState."""
        return self.confinement.state if self.running else _STOPPED

    # the bus's side

    def received(self, box: Mailbox, at_ns: int) -> None:
        self.frames_received += 1
        self.host.received(box, at_ns)

    def transmitted(self, box: Mailbox, at_ns: int) -> None:
        self.frames_sent += 1
        if self.confinement.tec and self.confinement.transmitted():
            self._state_changed(at_ns)
        self.host.transmitted(box, at_ns)
        box.occupied = False
        self._make_offer()
        self.host.fill(at_ns)

    def arbitration_lost(self, box: Mailbox, bit: int, at_ns: int) -> None:
        self.host.event(_ARBITRATION_LOST, 0, bit, True, at_ns, 0)
        if box.single_shot and box.occupied:
            self._give_up(box, at_ns)

    def error(self, kind: int, bit: int, transmitting: bool, rule: int, at_ns: int) -> None:
        self.errors += 1
        self.last_error = kind
        changed = not self.restricted and self.confinement.apply(rule)
        self.tainted = self.confinement.rec > 0
        self.host.event(_ERROR, kind, bit, transmitting, at_ns, 0)
        if changed:
            self._state_changed(at_ns)
        box = self.contending
        if transmitting and box is not None and box.occupied and (box.single_shot or box.abort_on_error):
            self._give_up(box, at_ns)

    def count(self, rule: int, at_ns: int) -> None:
        changed = not self.restricted and self.confinement.apply(rule)
        self.tainted = self.confinement.rec > 0
        if changed:
            self._state_changed(at_ns)

    def joined(self, at_ns: int) -> None:
        self.on_bus = True
        self._wait(0, at_ns)
        recovered = self.confinement.state == _BUS_OFF
        if recovered:
            self.confinement.reset()
        self._take_state()
        self._changed()
        if recovered:
            self.host.event(_STATE, 0, -1, False, at_ns, 0)
        self.host.fill(at_ns)

    # between the two

    def _take_options(self, options: ControllerOptions) -> None:
        self.loop_ps = round(options.loop_delay_ns * 1000)
        self.edge_filter = options.edge_filter
        self.restricted = options.restricted
        self.protocol_exception = options.protocol_exception if self.fd else options.fd_tolerant
        compensation = options.compensation
        self.compensates = compensation is not None
        if compensation is not None:
            offset_ns = compensation.offset_ns
            self.second_sample_ps = self.data_sample_ps if offset_ns is None else round(offset_ns * 1000)
            self.least_second_ps = round(compensation.filter_ns * 1000)
            self.measures_delay = compensation.measured

    def _make_offer(self) -> None:
        if self.restricted:
            self.offer = None
        elif self.high.occupied:
            self.offer = self.high
        elif self.normal.occupied:
            self.offer = self.normal
        else:
            self.offer = None

    def _give_up(self, box: Mailbox, at_ns: int) -> None:
        self.host.aborted(box, at_ns)
        box.occupied = False
        self._make_offer()
        self.host.fill(at_ns)

    def _state_changed(self, at_ns: int) -> None:
        self._take_state()
        if self.confinement.state == _BUS_OFF:
            self.on_bus = False
            self._changed()
        self.host.event(_STATE, 0, -1, False, at_ns, 0)

    def _take_state(self) -> None:
        self.passive = self.confinement.state >= _PASSIVE
        self.tainted = self.confinement.rec > 0

    def _wait(self, sequences: int, at_ns: int) -> None:
        self.waiting = sequences
        self.sequences = 0
        self.waiting_from_ns, self.waiting_from_ps = at_ns, 0

    def _interrupt(self) -> None:
        if self.bus is not None:
            self.bus.interrupt()

    def _changed(self) -> None:
        if self.bus is not None:
            self.bus.changed()
