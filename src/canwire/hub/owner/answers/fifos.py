"""The hub's answers to requests about FIFOs."""

from __future__ import annotations

from canwire.hub.owner.answers.registry import DONE, Answers
from canwire.hub.owner.held.pipes import HeldPipe
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer
from canwire.hub.protocol.roles import FIFO

answers = Answers()


@answers.to(m.CreateFifo)
def _create_fifo(request: m.CreateFifo, session: Session, world: World) -> Answer:
    session.check_room(HeldPipe)
    world.pipes.create(number := world.next_luid(), request.capacity, request.element_size)
    return _fifo(session, world, number, FIFO)


@answers.to(m.OpenFifo)
def _open_fifo(request: m.OpenFifo, session: Session, world: World) -> Answer:
    return _fifo(session, world, request.fifo, request.role)


@answers.to(m.ResetFifo)
def _reset_fifo(request: m.ResetFifo, session: Session, world: World) -> Answer:
    world.pipes.reset(session.look_up(request.handle, HeldPipe).pipe)
    return DONE


def _fifo(session: Session, world: World, number: int, role: str) -> Answer:
    session.check_room(HeldPipe)
    pipe = world.pipes.open(number, role)
    try:
        copies = pipe.copies()
    except OSError:
        world.pipes.close(pipe, role)
        raise
    handle = session.hold(HeldPipe(world.pipes, pipe, role))
    return m.FifoOpened(handle, pipe.id, pipe.capacity, pipe.element_size), copies
