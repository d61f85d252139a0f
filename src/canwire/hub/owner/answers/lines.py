"""The hub's answers to requests about CAN lines; start, stop and reset also apply to LIN lines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from canwire.boards.can.connector import CanLine
from canwire.boards.can.modes import LineStatus
from canwire.boards.lin.line import LinLine
from canwire.errors import CanwireError, Unsupported, WrongState
from canwire.hub.owner.answers.registry import DONE, Answers
from canwire.hub.owner.deferred import Deferred
from canwire.hub.owner.held.can import CanSlot
from canwire.hub.owner.held.lin import LinSlot
from canwire.hub.owner.held.line import HeldControl
from canwire.hub.owner.rates import Neighbours
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer

answers = Answers()


@answers.to(m.GetLineStatus)
def _get_line_status(request: m.GetLineStatus, session: Session, world: World) -> Answer:
    slot = world.can_slot(request.board, request.line)
    return m.LineState(_status(slot, world.lateness(), world.rates.others(), request.kin)), ()


@answers.to(m.GetLineStatuses)
def _get_line_statuses(request: m.GetLineStatuses, session: Session, world: World) -> Answer:
    slots = world.slots_of(request.boards)
    lateness = world.lateness()  # once: it looks at every controller
    others = world.rates.others()
    found = ((at, slot) for at, slot in slots if isinstance(slot, CanSlot))
    return m.LineStatuses(tuple((*at, _status(slot, lateness, others)) for at, slot in found)), ()


def _status(slot: CanSlot, lateness: tuple[int, int], others: Neighbours, kin: str = "") -> LineStatus:
    behind_ns, skipped_ns = lateness
    return replace(slot.status(kin), behind_ns=behind_ns, skipped_ns=skipped_ns, neighbours=others.of(slot))


@answers.to(m.Initialise)
def _initialise(request: m.Initialise, session: Session, world: World) -> Deferred:
    slot = _slot_of(session, request.handle)
    return _later(lambda done: slot.initialise(session, request.mode, done), numbered=False)


@answers.to(m.Start)
def _start(request: m.Start, session: Session, world: World) -> Answer:
    can = _commanded(session, request.handle)
    if request.abort_pending and isinstance(can, CanLine):
        can.abort_pending()
    can.start()
    if isinstance(can, CanLine):
        world.look_at_rates(can.info.bus)
    return DONE


@answers.to(m.Stop)
def _stop(request: m.Stop, session: Session, world: World) -> Deferred:
    return _later(_commanded(session, request.handle).stop, numbered=False)


@answers.to(m.Recover)
def _recover(request: m.Recover, session: Session, world: World) -> Deferred:
    slot = world.can_slot(request.board, request.line)
    if not slot.used_by(session):
        raise WrongState(f"{slot.name}: {session.name} has nothing open on it; open a channel first")
    return _later(lambda done: slot.can.recover(done, abort_pending=request.abort_pending), numbered=False)


@answers.to(m.Reset)
def _reset(request: m.Reset, session: Session, world: World) -> Answer:
    can = _commanded(session, request.handle)
    if isinstance(can, CanLine):
        can.reset(kin_of(session, request.handle))
    else:
        can.reset()
    return DONE


@answers.to(m.Detect)
def _detect(request: m.Detect, session: Session, world: World) -> Deferred:
    can = can_of(session, request.handle)
    return _later(
        lambda done: can.detect(
            request.candidates, request.timeout_ms, request.iso_fd, done, low_speed=request.low_speed
        ),
        numbered=True,
    )


def can_of(session: Session, handle: int) -> CanLine:
    """The CAN line of this control; raises Unsupported for the control of a LIN line."""
    return _slot_of(session, handle).can


def kin_of(session: Session, handle: int) -> str:
    """The interface of the program that has this control."""
    return session.look_up(handle, HeldControl).kin


def _slot_of(session: Session, handle: int) -> CanSlot:
    slot = session.look_up(handle, HeldControl).slot
    if not isinstance(slot, CanSlot):
        raise Unsupported(f"{slot.name} is a LIN line: it has no bit timing, filters and detection")
    return slot


def _commanded(session: Session, handle: int) -> CanLine | LinLine:
    """The line of either kind that this control is of."""
    slot = session.look_up(handle, HeldControl).slot
    return slot.lin if isinstance(slot, LinSlot) else can_of(session, handle)


def _later(begin: Callable[[Callable[[int | CanwireError], None]], None], *, numbered: bool) -> Deferred:
    """An answer once what `begin` starts is done."""
    deferred = Deferred()

    def done(result: int | CanwireError) -> None:
        if isinstance(result, CanwireError):
            deferred.settle(result)
        else:
            deferred.settle((m.Number(result), ()) if numbered else DONE)

    begin(done)
    return deferred
