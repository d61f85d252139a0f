"""The hub's answers to requests to open access layers, the control of a line and its shares, and to close a lease."""

from __future__ import annotations

from canwire.boards.sharing import Share
from canwire.errors import BadValue, InUse
from canwire.hub.owner.answers.registry import DONE, Answers, opened
from canwire.hub.owner.held.can import HeldShare
from canwire.hub.owner.held.layer import HeldLayer
from canwire.hub.owner.held.line import HeldControl, HeldSettings
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer

_SHARE_MODES = range(4)

answers = Answers()


@answers.to(m.OpenLayer)
def _open_layer(request: m.OpenLayer, session: Session, world: World) -> Answer:
    session.check_room(HeldLayer)
    board = world.board(request.board)
    for other in world.sessions:
        for layer in other.held(HeldLayer):
            if layer.board == request.board and layer.layer != request.layer:
                raise InUse(f"{board.info.hardware_id}: layer {layer.layer!r} is open, by {other.name}")
    return opened(session, HeldLayer(request.board, request.layer))


@answers.to(m.OpenControl)
def _open_control(request: m.OpenControl, session: Session, world: World) -> Answer:
    session.check_room(HeldControl)
    slot = world.line_slot(request.board, request.line)
    slot.admit("its control", slot.control)
    slot.control = session
    return opened(session, HeldControl(slot, request.kin))


@answers.to(m.KeepSettings)
def _keep_settings(request: m.KeepSettings, session: Session, world: World) -> Answer:
    session.check_room(HeldSettings)
    return opened(session, HeldSettings(world.line_slot(request.board, request.line)))


@answers.to(m.OpenShare)
def _open_share(request: m.OpenShare, session: Session, world: World) -> Answer:
    session.check_room(HeldShare)
    slot = world.can_slot(request.board, request.line)
    if request.share not in _SHARE_MODES:
        raise BadValue(f"share mode {request.share}: 1 for reading, 2 for writing, 3 both, 0 none")
    share = Share(session.name, request.read, request.write, request.share)
    slot.sharing.open(share)
    return opened(session, HeldShare(slot, share))


@answers.to(m.Close)
def _close(request: m.Close, session: Session, world: World) -> Answer:
    session.look_up(request.handle, object)
    session.release(request.handle)
    return DONE
