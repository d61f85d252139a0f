"""The hub's answers to requests about the filters of CAN lines and channels."""

from __future__ import annotations

from canwire.boards.can.message_filter import FormatFilter
from canwire.boards.can.modes import FilterMode
from canwire.errors import BadFilter, WrongState
from canwire.hub.owner.answers.lines import can_of, kin_of
from canwire.hub.owner.answers.registry import DONE, Answers
from canwire.hub.owner.held.channel import HeldChannel
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer

answers = Answers()


@answers.to(m.GetFilterMode)
def _get_filter_mode(request: m.GetFilterMode, session: Session, world: World) -> Answer:
    held = session.look_up(request.handle, object)
    if isinstance(held, HeldChannel):
        return m.Number(held.format_filter(request.extended).mode), ()
    return m.Number(
        can_of(session, request.handle).filter_mode(request.extended, kin_of(session, request.handle))
    ), ()


@answers.to(m.SetFilterMode)
def _set_filter_mode(request: m.SetFilterMode, session: Session, world: World) -> Answer:
    found = _filter(session, request.handle, request.extended)
    if request.mode not in (
        FilterMode.LOCK,
        FilterMode.PASS,
        FilterMode.INCLUSIVE,
        FilterMode.EXCLUSIVE,
    ):
        raise BadFilter(f"filter mode {request.mode}: 1 lock, 2 pass, 3 inclusive, 4 exclusive")
    before, found.mode = found.mode, request.mode
    return m.Number(before), ()


@answers.to(m.SetAcceptanceFilter)
def _set_acceptance_filter(request: m.SetAcceptanceFilter, session: Session, world: World) -> Answer:
    _filter(session, request.handle, request.extended).set_pattern(request.code, request.mask)
    return DONE


@answers.to(m.ListIds)
def _list_ids(request: m.ListIds, session: Session, world: World) -> Answer:
    found = _filter(session, request.handle, request.extended)
    (found.add if request.add else found.remove)(request.code, request.mask)
    return DONE


@answers.to(m.ReplaceFilters)
def _replace_filters(request: m.ReplaceFilters, session: Session, world: World) -> Answer:
    session.look_up(request.handle, HeldChannel).replace_filters(request.standard, request.extended)
    return DONE


def _filter(session: Session, handle: int, extended: bool) -> FormatFilter:
    """The filter of a control's line or of a channel, to be changed: they must not be at work."""
    held = session.look_up(handle, object)
    if isinstance(held, HeldChannel):
        held.check_inactive()
        return held.format_filter(extended)
    can = can_of(session, handle)
    if can.running:
        raise WrongState(f"{can.line.name}: stop the line to change its filter")
    return can.format_filter(extended, kin_of(session, handle))
