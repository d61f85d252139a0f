"""Where the bits of each node begin: when a bus comes to rest, and when it changes to the bit level in mid-bit.

Between frames the bits of nodes need not be aligned: after an error in a data phase each node counts from its own
sample point. bus.py and bit_level.py call these functions once or twice per frame.
Source: ISO 11898-1:2015 10.4.6 (interframe space), 8.2.6 (bus integration).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from canwire.bus.can.node import Node
from canwire.bus.can.station import ACTIVE_FLAG, IDLE, INTERMISSION, PASSIVE_FLAG, SUSPEND, WAITING, Station

_GROUP, _FLAG_BITS, _INTERMISSION_BITS = 11, 6, 3


class Clock(Protocol):
    """The part of bit_level.py's clock that this file uses."""

    station: Station
    node: Node
    start_ps: int
    due_ps: int
    sampling: bool
    edged: bool

    def begin(self, at_ps: int) -> None: ...


def hand_back(clock: Clock, origin_ps: int) -> None:
    """Give a node the values that only its station knows; bits count from the last boundary up to which it sampled."""
    station, node = clock.station, clock.node
    at_ps = origin_ps + (clock.start_ps if clock.sampling else clock.due_ps)
    if station.state == SUSPEND:
        node.suspended_ns = at_ps // 1000 + station.left * node.bit_ps // 1000
    elif station.state == WAITING:
        # idle bits from before the beginning of time count, too
        from_ps = max(0, at_ps - station.run * node.bit_ps)
        node.waiting_from_ns, node.waiting_from_ps = divmod(from_ps, 1000)


def request(clocks: Sequence[Clock], node: Node, at_ps: int) -> None:
    """Let an idle node send now: it need not wait for its next bit boundary, unless an edge has set it."""
    for clock in clocks:
        station = clock.station
        idle = station.state == IDLE and not clock.edged and not station.just_free
        if clock.node is node and idle and clock.start_ps != at_ps:
            clock.due_ps = at_ps
            clock.sampling = False


def resume_frame(clocks: Sequence[Clock]) -> None:
    """Continue after an SOF: only nodes that still contend take part in the frame as senders."""
    for clock in clocks:
        station = clock.station
        if station.contending is None and station.state == IDLE:
            station.sof_seen = True


def fail_unacknowledged(clocks: Sequence[Clock], sender: Node, slot: int, passive: bool) -> None:
    """Continue at the start of an ACK slot without acknowledge: the sender already knows of the acknowledge error."""
    for clock in clocks:
        if clock.node is sender:
            _fail_unacknowledged(clock.station, slot, passive)
            clock.sampling = False
            clock.due_ps = sender.bit_ps


def _fail_unacknowledged(station: Station, slot: int, passive: bool) -> None:
    """Continue from the frame's bit `slot`, an ACK slot without acknowledge, which the node knows already."""
    station.contending = None
    station.index = slot + 1
    station.transmitting = station.flagged = station.tally.erring = True
    station.tec_due = passive
    station.state, station.left = (PASSIVE_FLAG if passive else ACTIVE_FLAG), _FLAG_BITS
    station.run = station.dominant_run = 0


def resume_intermission(clocks: Sequence[Clock], sender: Node) -> None:
    """Continue at the start of the intermission after a frame, for all nodes that received it; a suspended node sent
    it.
    """
    for clock in clocks:
        station = clock.station
        if station.state == SUSPEND:
            clock.begin(
                0
            )  # that its suspend time is known in whole nanoseconds moves no bit of the intermission
        sent = clock.node is sender or station.state == SUSPEND
        station.contending = None
        if station.state != WAITING:
            station.state, station.transmitting, station.left = INTERMISSION, sent, _INTERMISSION_BITS


def resume(clocks: Sequence[Clock], origin_ps: int, quiet_from_ps: int) -> None:
    """Continue between frames, in the present bits of nodes that wait or are suspended."""
    for clock in clocks:
        if clock.station.state == WAITING:
            resume_waiting(clock, origin_ps, quiet_from_ps)
        elif clock.station.state == IDLE:
            resume_suspended(clock, origin_ps)


def resume_waiting(clock: Clock, origin_ps: int, quiet_from_ps: int) -> None:
    """Continue the count of recessive bits from when the bus was quiet and the node attached."""
    station, node = clock.station, clock.node
    elapsed_ps = origin_ps - max(node.waiting_from_ns * 1000 + node.waiting_from_ps, quiet_from_ps)
    if elapsed_ps <= 0:
        clock.due_ps = -elapsed_ps
        return
    seen = _place(clock, elapsed_ps)
    node.sequences += seen // _GROUP
    station.run = seen % _GROUP
    station.rejoined = bool(node.waiting) and node.sequences >= node.waiting


def resume_suspended(clock: Clock, origin_ps: int) -> None:
    """Continue the suspend time, whose last bit ends when the node may send."""
    station, node = clock.station, clock.node
    missing_ps = node.suspended_ns * 1000 - origin_ps
    if missing_ps <= 0:
        return
    bits = -(-missing_ps // node.bit_ps)
    station.left = bits - _place(clock, bits * node.bit_ps - missing_ps)
    if station.left:
        station.state = SUSPEND


def _place(clock: Clock, elapsed_ps: int) -> int:
    """Put a clock `elapsed_ps` after a boundary; returns how many bits it has sampled since then."""
    node = clock.node
    bits, offset_ps = divmod(elapsed_ps, node.bit_ps)
    sampled = offset_ps > node.sample_ps  # at the very sample point it is about to
    clock.start_ps = -offset_ps
    clock.sampling = offset_ps > 0 and not sampled
    clock.due_ps = (node.sample_ps if clock.sampling else node.bit_ps if offset_ps else 0) - offset_ps
    return int(bits + sampled)
