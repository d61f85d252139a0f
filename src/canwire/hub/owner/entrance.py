"""Where clients come in: every link opens its session here."""

from __future__ import annotations

from collections.abc import Callable

from canwire.hub.owner.answers.everything import ANSWERS
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol.messages import Message
from canwire.platform import EventDescriptor


def open_session(
    world: World, name: str, pid: int, notify: Callable[[Message], None], doorbell: EventDescriptor | None
) -> Session:
    """A client has come; `notify` passes notices on to it. `World.close_session` when it goes."""
    session = Session(
        f"{name} ({pid})",
        notify,
        doorbell,
        virtual=world.virtual,
        limits=world.limits,
        answer=lambda request, asking: ANSWERS.answer(request, asking, world),
        changed=world.look_anew,
    )
    world.sessions.append(session)
    return session
