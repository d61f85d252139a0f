"""The hub's answers to requests about lockstep time."""

from __future__ import annotations

from canwire.errors import WrongState
from canwire.hub.owner.answers.registry import DONE, Answers
from canwire.hub.owner.deferred import Deferred
from canwire.hub.owner.lockstep.keeper import Lockstep
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer
from canwire.values.checks import pace

answers = Answers()


@answers.to(m.JoinTime)
def _join(request: m.JoinTime, session: Session, world: World) -> Deferred:
    return _kept(world).join(session, request)


@answers.to(m.AwaitTurn)
def _await_turn(request: m.AwaitTurn, session: Session, world: World) -> Deferred:
    return _kept(world).wait(session, request)


@answers.to(m.LeaveTime)
def _leave(request: m.LeaveTime, session: Session, world: World) -> Answer:
    _kept(world).leave(session, request.thread)
    return DONE


@answers.to(m.Stir)
def _stir(request: m.Stir, session: Session, world: World) -> Answer:
    _kept(world).stir()
    return DONE


@answers.to(m.SetPace)
def _set_pace(request: m.SetPace, session: Session, world: World) -> Answer:
    if not world.virtual:
        raise WrongState("a pace is for a hub in lockstep or virtual time: this one's passes with the clock")
    world.held.hold(pace(request.factor or None))
    return DONE


@answers.to(m.GetTime)
def _get_time(request: m.GetTime, session: Session, world: World) -> Answer:
    kept = world.lockstep
    return m.TimeState(world.timeline.now_ns, (), "", world.held.factor) if kept is None else kept.state(), ()


def _kept(world: World) -> Lockstep:
    """The Lockstep of the hub; raises WrongState if the hub is not in lockstep mode."""
    if world.lockstep is None:
        raise WrongState(
            "this hub is not in lockstep mode: start it with `canwire serve --time lockstep`, or connect without "
            "timed (CANWIRE_TIMED)"
        )
    return world.lockstep
