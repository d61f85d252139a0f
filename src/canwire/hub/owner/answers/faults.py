"""The hub's answers to requests about faults on its buses."""

from __future__ import annotations

from canwire.hub.owner.answers.registry import Answers, opened
from canwire.hub.owner.deferred import Deferred
from canwire.hub.owner.faults.live import HeldFault, LiveFault
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer
from canwire.timeline import Timer

answers = Answers()


@answers.to(m.GetBus)
def _get_bus(request: m.GetBus, session: Session, world: World) -> Answer:
    return m.BusFound(world.faults.bus_type(request.bus)), ()


@answers.to(m.SetFault)
def _set_fault(request: m.SetFault, session: Session, world: World) -> Answer:
    live = world.faults.set(request.bus, request.fault, session, request.lasting_ns, request.persistent)
    world.look_at_rates(request.bus)  # an oscillator may be too far off now
    return opened(session, HeldFault(live, world.faults.release))


@answers.to(m.GetFault)
def _get_fault(request: m.GetFault, session: Session, world: World) -> Answer:
    return _state(_live(session, request.handle))


@answers.to(m.AwaitFault)
def _await_fault(request: m.AwaitFault, session: Session, world: World) -> Answer | Deferred:
    live = _live(session, request.handle)
    if live.over:
        return _state(live)
    deferred = Deferred()
    timer: Timer | None = None

    def tell() -> None:
        if tell in live.waiting:
            live.waiting.remove(tell)
        if timer is not None:
            timer.cancel()
        deferred.settle(_state(live))

    live.waiting.append(tell)
    if request.timeout_ns is not None:
        timer = world.timeline.at(world.timeline.now_ns + max(0, request.timeout_ns), tell)
    return deferred


@answers.to(m.CancelFault)
def _cancel_fault(request: m.CancelFault, session: Session, world: World) -> Answer:
    live = _live(session, request.handle)
    world.faults.cancel(live)
    return _state(live)


@answers.to(m.ListFaults)
def _list_faults(request: m.ListFaults, session: Session, world: World) -> Answer:
    return m.FaultList(world.faults.on(request.bus)), ()


@answers.to(m.ClearFaults)
def _clear_faults(request: m.ClearFaults, session: Session, world: World) -> Answer:
    return m.Number(world.faults.clear(request.bus, request.whose, session)), ()


def _live(session: Session, handle: int) -> LiveFault:
    return session.look_up(handle, HeldFault).live


def _state(live: LiveFault) -> Answer:
    return m.FaultState(live.info()), ()
