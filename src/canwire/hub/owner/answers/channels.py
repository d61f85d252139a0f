"""The hub's answers to requests about channels; monitors are activated by the same requests."""

from __future__ import annotations

from canwire.errors import NoSuchBoard
from canwire.hub.owner.answers.lin import lin_state
from canwire.hub.owner.answers.registry import DONE, Answers, opened
from canwire.hub.owner.held.channel import HeldChannel
from canwire.hub.owner.held.lin import HeldMonitor
from canwire.hub.owner.held.line import HeldQueue, OnLine
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer

answers = Answers()


@answers.to(m.OpenChannel)
def _open_channel(request: m.OpenChannel, session: Session, world: World) -> Answer:
    session.check_room(HeldChannel)
    slot = world.can_slot(request.board, request.line)
    slot.admit_queue(request.exclusive)
    held = HeldChannel(slot, session, request.exclusive)
    slot.queues.append(held)
    return opened(session, held)


@answers.to(m.SetUpChannel)
def _set_up_channel(request: m.SetUpChannel, session: Session, world: World) -> Answer:
    held = session.look_up(request.handle, HeldChannel)
    descriptors = held.set_up(request.mode, session.doorbell)
    assert held.channel is not None
    transmit = held.channel.transmit.capacity if held.channel.sends else 0
    return m.ChannelOpened(held.channel.receive.capacity, transmit), descriptors


@answers.to(m.CountRefused)
def _count_refused(request: m.CountRefused, session: Session, world: World) -> Answer:
    session.look_up(request.handle, HeldChannel).count_refused(request.count)
    return DONE


@answers.to(m.Activate)
def _activate(request: m.Activate, session: Session, world: World) -> Answer:
    held = session.look_up(request.handle, OnLine)
    if not isinstance(held, HeldQueue):
        raise NoSuchBoard(f"handle {request.handle} is neither a channel nor a monitor of {session.name}")
    held.activate(request.active)
    if isinstance(held, HeldChannel):
        return m.LineState(held.slot.status(held.kin)), ()
    assert isinstance(held, HeldMonitor)
    return lin_state(held.slot), ()


@answers.to(m.GetChannelStatus)
def _get_channel_status(request: m.GetChannelStatus, session: Session, world: World) -> Answer:
    return m.ChannelState(session.look_up(request.handle, HeldChannel).status()), ()


@answers.to(m.CancelQueued)
def _cancel_queued(request: m.CancelQueued, session: Session, world: World) -> Answer:
    held = session.look_up(request.handle, HeldChannel)
    if held.channel is None:
        return m.Number(0), ()
    return m.Number(held.slot.can.line.cancel(held.channel, request.loaded)), ()


@answers.to(m.PassOn)
def _pass_on(request: m.PassOn, session: Session, world: World) -> Answer:
    session.look_up(request.handle, HeldChannel).pass_on(request.record)
    return DONE
