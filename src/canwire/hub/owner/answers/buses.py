"""The hub's answers to requests about the wires of its buses."""

from __future__ import annotations

from canwire.hub.owner.answers.registry import DONE, Answers
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer

answers = Answers()


@answers.to(m.Disturb)
def _disturb(request: m.Disturb, session: Session, world: World) -> Answer:
    world.short(request.bus, request.shorted)
    return DONE
