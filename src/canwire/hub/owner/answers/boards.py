"""The hub's answers to requests about its boards."""

from __future__ import annotations

from canwire.boards.inducan104 import checked_place
from canwire.boards.outside import check_port
from canwire.hub.owner.answers.registry import DONE, Answers
from canwire.hub.owner.limits import check_room
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer

_PAGE = 256  # boards in one reply: some milliseconds of work

answers = Answers()


@answers.to(m.ListBoards)
def _list_boards(request: m.ListBoards, session: Session, world: World) -> Answer:
    found = tuple(info for info in world.infos() if info.id > request.after)
    return m.Boards(found[:_PAGE], len(found) > _PAGE), ()


@answers.to(m.Watch)
def _watch(request: m.Watch, session: Session, world: World) -> Answer:
    session.watching = True
    return DONE


@answers.to(m.Plug)
def _plug(request: m.Plug, session: Session, world: World) -> Answer:
    check_room(session.limits, "boards", len(session.plugged), session.name)
    place = None
    if request.base is not None or request.irq is not None or request.shared_irq:
        place = checked_place(request.base, request.irq, request.shared_irq)
    check_port(request.kind, request.port)
    board = world.plug(request.kind, request.serial, request.buses, place, port=request.port)
    session.plugged[board.hardware_id] = request.temporary
    return m.Plugged(board), ()


@answers.to(m.Unplug)
def _unplug(request: m.Unplug, session: Session, world: World) -> Answer:
    world.unplug(request.hardware_id)
    return DONE
