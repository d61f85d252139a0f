"""The hub's answers to requests about cyclic transmit lists."""

from __future__ import annotations

from canwire.boards.can.cyclic_object import Increment
from canwire.boards.can.modes import CyclicStatus
from canwire.boards.can.scheduler import CyclicList
from canwire.boards.description import Feature
from canwire.errors import BadFrame, BadValue, Unsupported
from canwire.hub.owner.answers.registry import DONE, Answers, opened
from canwire.hub.owner.held.can import HeldScheduler
from canwire.hub.owner.held.channel import HeldChannel
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer
from canwire.values.frame import Frame, frame_of_record
from canwire.values.record import HIGH_PRIORITY, SELF_RECEPTION, SINGLE_SHOT

_CYCLIC_FLAGS = SINGLE_SHOT | HIGH_PRIORITY | SELF_RECEPTION
_KIND_AT = 12  # byte of a record: 0 for frames

answers = Answers()


@answers.to(m.OpenScheduler)
def _open_scheduler(request: m.OpenScheduler, session: Session, world: World) -> Answer:
    session.check_room(HeldScheduler)
    slot = world.can_slot(request.board, request.line)
    ticks = slot.can.info.capabilities.cyclic
    if not slot.can.info.capabilities.can(Feature.SCHEDULER):
        raise Unsupported(f"{slot.can.line.name} has no cyclic transmit list")
    slot.admit("its cyclic list", slot.scheduler)
    slot.scheduler, slot.scheduler_kin = session, request.kin
    cyclic = CyclicList(slot.can.line, world.timeline, ticks.tick_ns, ticks.maximum, kin=request.kin)
    return opened(session, HeldScheduler(slot, cyclic))


@answers.to(m.AddCyclic)
def _add_cyclic(request: m.AddCyclic, session: Session, world: World) -> Answer:
    held = session.look_up(request.handle, HeldScheduler)
    owner = session.look_up(request.channel, HeldChannel).channel if request.channel else None
    frame = _cyclic_frame(request.record)
    flags = int.from_bytes(request.record[12:16], "little") & _CYCLIC_FLAGS
    if request.increment not in list(Increment):
        raise BadValue(f"increment {request.increment}: 0 none, 1 identifier, 2 byte, 3 two bytes")
    index = held.cyclic.add(
        frame,
        request.cycle,
        increment=Increment(request.increment),
        byte_index=request.byte_index,
        flags=flags,
        owner=owner,
    )
    return m.Number(index), ()


@answers.to(m.ReplaceCyclic)
def _replace_cyclic(request: m.ReplaceCyclic, session: Session, world: World) -> Answer:
    frame = _cyclic_frame(request.record)
    session.look_up(request.handle, HeldScheduler).cyclic.replace(request.index, frame)
    return DONE


@answers.to(m.StartInTurn)
def _start_in_turn(request: m.StartInTurn, session: Session, world: World) -> Answer:
    cyclic = session.look_up(request.handle, HeldScheduler).cyclic
    cyclic.start_in_turn(request.indices, request.counts, request.step)
    return DONE


@answers.to(m.RemoveCyclic)
def _remove_cyclic(request: m.RemoveCyclic, session: Session, world: World) -> Answer:
    session.look_up(request.handle, HeldScheduler).cyclic.remove(request.index)
    return DONE


@answers.to(m.StartCyclic)
def _start_cyclic(request: m.StartCyclic, session: Session, world: World) -> Answer:
    session.look_up(request.handle, HeldScheduler).cyclic.start(request.index, request.count)
    return DONE


@answers.to(m.StopCyclic)
def _stop_cyclic(request: m.StopCyclic, session: Session, world: World) -> Answer:
    session.look_up(request.handle, HeldScheduler).cyclic.stop(request.index)
    return DONE


@answers.to(m.RunScheduler)
def _run_scheduler(request: m.RunScheduler, session: Session, world: World) -> Answer:
    cyclic = session.look_up(request.handle, HeldScheduler).cyclic
    (cyclic.resume if request.running else cyclic.suspend)()
    return DONE


@answers.to(m.ResetScheduler)
def _reset_scheduler(request: m.ResetScheduler, session: Session, world: World) -> Answer:
    session.look_up(request.handle, HeldScheduler).cyclic.reset()
    return DONE


@answers.to(m.GetSchedulerStatus)
def _get_scheduler_status(request: m.GetSchedulerStatus, session: Session, world: World) -> Answer:
    cyclic = session.look_up(request.handle, HeldScheduler).cyclic
    return m.SchedulerState(CyclicStatus(cyclic.running, cyclic.states(), cyclic.skipped)), ()


def _cyclic_frame(record: bytes) -> Frame:
    """Raises BadFrame for an event."""
    frame = frame_of_record(record)
    if record[_KIND_AT]:
        raise BadFrame("a cyclic list sends frames: this record is an event's")
    return frame
