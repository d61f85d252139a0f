"""Start a CAN line that other programs may be using or starting as well."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire.boards.can.modes import LineMode, LineStatus
from canwire.errors import InUse
from canwire.values.checks import shown
from canwire.values.mistakes.calls import answers_wrong_calls

if TYPE_CHECKING:
    from canwire.hub.finding import LinePlace
    from canwire.hub.handles.control import Control
    from canwire.hub.handles.hub import Hub

_LOOK_S = 0.02
_PATIENCE_S = 2.0  # for another program that is just starting the same line


def bring_up(
    hub: Hub,
    place: LinePlace,
    mode_for: Callable[[LineStatus], LineMode | None],
    check: Callable[[LineStatus], None],
    *,
    patience_s: float = _PATIENCE_S,
) -> Control | None:
    """Start the line unless it runs; return its control if this program started it, else None.

    Joining a running line needs no control. The program that started it should close the control once it has a channel
    on the line: the channel keeps the line running, and other programs may then recover it. `mode_for(status)` returns
    the mode for a line that does not run, None to leave it as it is. `check(status)` raises if a running line is not
    suitable. If another program has the control of a stopped line, it has `patience_s` seconds of the hub's time to
    start it; then InUse is raised with the name of that program.
    """
    status = place.status(hub)
    if status.running:
        check(status)
        return None
    try:
        control = hub.open_control(place.board.id, place.line)
    except InUse as refusal:
        check(_started_by_somebody(hub, place, refusal, patience_s))
        return None
    with ExitStack() as on_failure:
        on_failure.enter_context(control)
        status = place.status(hub)
        if not status.running:
            _start(control, mode_for(status))
            on_failure.pop_all()
            return control
    check(status)
    return None


@answers_wrong_calls
def start_line(hub: Hub, place: LinePlace, mode: LineMode | None, *, unused: bool = False) -> Control:
    """Take the line's control, set the line up (None: keep its settings) and start it.

    Raises InUse while another program has the control, and what `Control.initialise` and `Control.start` raise.
    `unused`: the line was found to be unused, and InUse is raised if it runs or a program has a channel on it by now.
    """
    if not hasattr(place, "board"):
        raise TypeError(f"place {shown(place)}: must be LinePlace, one of find_lines(hub, name)")
    with ExitStack() as on_failure:
        control = on_failure.enter_context(hub.open_control(place.board.id, place.line))
        if unused:
            _check_unused(place, place.status(hub))
        _start(control, mode)
        on_failure.pop_all()
    return control


def _start(control: Control, mode: LineMode | None) -> None:
    if mode is not None:
        control.initialise(mode)
    control.start()


def _check_unused(place: LinePlace, status: LineStatus) -> None:
    if status.running or status.channels:
        raise InUse(f"{place.address}: another program has begun to use this line")


def _started_by_somebody(hub: Hub, place: LinePlace, refusal: InUse, patience_s: float) -> LineStatus:
    end_s = hub.clock_s() + patience_s
    while not (status := place.status(hub)).running:
        if hub.clock_s() >= end_s:
            raise refusal
        hub.sleep(_LOOK_S)
    return status
