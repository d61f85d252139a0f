"""Opens and serves the session of each client; all links use it."""

from __future__ import annotations

from collections.abc import Callable

from canwire.hub.owner.answers.everything import ANSWERS
from canwire.hub.owner.deferred import Deferred
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol.link import Answer
from canwire.hub.protocol.messages import Message
from canwire.platform import EventDescriptor


def open_session(
    world: World, name: str, pid: int, notify: Callable[[Message], None], doorbell: EventDescriptor | None
) -> Session:
    """Open the session of a new client; `notify` passes notices to it. Call `World.close_session` at its end."""
    session = Session(
        f"{name} ({pid})",
        notify,
        doorbell,
        halts=world.timeline if world.virtual and world.lockstep is None else None,
        limits=world.limits,
        answer=lambda request, asking: _answer(request, asking, world),
        changed=world.look_anew,
        bells=world.bells,
    )
    world.sessions.append(session)
    return session


def _answer(request: Message, session: Session, world: World) -> Answer | Deferred:
    """Answer a request; an answer that takes time ends the turn of a program in lockstep."""
    answer = ANSWERS.answer(request, session, world)
    if not isinstance(answer, tuple):
        session.await_answer(answer)
    if world.lockstep is None or isinstance(answer, tuple):
        return answer
    return world.lockstep.blocked(session, answer)


def rung(world: World, session: Session, doorbell: EventDescriptor) -> None:
    """A client has signalled its doorbell: it wrote into a transmit queue, or read from a full receive queue."""
    if world.lockstep is None or not world.lockstep.has(session):
        doorbell.take()
        world.kick(session)
    elif doorbell.take():  # else this was looked at already, when its thread began to wait
        world.lockstep.rung(session)
