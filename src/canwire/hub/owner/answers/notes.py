"""The hub's answers to requests about notes that programs leave for each other, and about unique numbers."""

from __future__ import annotations

from canwire.hub.owner.answers.registry import DONE, Answers
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer

answers = Answers()


@answers.to(m.CreateLuid)
def _create_luid(request: m.CreateLuid, session: Session, world: World) -> Answer:
    return m.Number(world.next_luid()), ()


@answers.to(m.GetNote)
def _get_note(request: m.GetNote, session: Session, world: World) -> Answer:
    return m.Note(world.notes.get(request.name)), ()


@answers.to(m.ListNotes)
def _list_notes(request: m.ListNotes, session: Session, world: World) -> Answer:
    return m.Notes(world.notes.beginning(request.prefix)), ()


@answers.to(m.SetNote)
def _set_note(request: m.SetNote, session: Session, world: World) -> Answer:
    world.notes.set(request.name, request.value, session, leaves=request.leaves)
    return DONE
