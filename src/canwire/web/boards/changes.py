"""The actions of the page on boards and lines."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import canwire
from canwire import (
    BadTiming,
    BadValue,
    LineMode,
    LinePlace,
    LineStatus,
    WantedMode,
    format_rates,
    format_setter,
    kind_names,
)
from canwire.web.lines import find_can_line

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire.web.actions import Call

FASTEST = 1_000_000
FASTEST_DATA = 10_000_000


def plug(call: Call) -> str:
    """Plug in a board: kind, serial, buses (names with spaces between them), base, irq, port."""
    fields = call.fields
    kind = fields.choice("kind", kind_names())
    serial = fields.text("serial", longest=40)
    buses = tuple(fields.text("buses").split())
    base = fields.hexadecimal("base", 0, 0xFFFF) if fields.text("base") else None
    irq = fields.whole("irq", 1, 15) if fields.text("irq") else None
    port = fields.text("port")
    fields.check()
    board = call.desk.link.hub.plug(kind, serial, buses, base=base, irq=irq, port=port)
    return call.word("boards.plugged", board=board.hardware_id, kind=board.kind)


def unplug(call: Call) -> str:
    board = call.fields.text("board", empty=False)
    call.fields.check()
    call.desk.link.hub.unplug(board)
    return call.word("boards.unplugged", board=board)


def up(call: Call) -> str:
    """Start a line at a bit rate; it runs until it is stopped, even after this page was closed."""
    fields, hub = call.fields, call.desk.link.hub
    address = fields.text("line", empty=False)
    bit_rate = fields.whole("rate", 1, FASTEST)
    data = fields.whole("datarate", 1, FASTEST_DATA) if fields.text("datarate") else None
    listen_only = fields.flag("listen")
    fields.check()
    place = find_can_line(hub, address)
    wanted = WantedMode(bit_rate, data, listen_only=listen_only)
    mode = _mode(call, place, wanted)

    def check(status: LineStatus) -> None:
        raise BadValue(
            call.word(
                "boards.runs", line=address, rates=format_rates(status.mode), setter=format_setter(status)
            )
        )

    control = canwire.bring_up(hub, place, lambda _: mode, check)
    if control is not None:
        control.close()
    return call.word("boards.started", line=address, rates=format_rates(place.status(hub).mode))


def _mode(call: Call, place: LinePlace, wanted: WantedMode) -> LineMode:
    """Return the line's mode; bit rates that the line's registers cannot make are faults of the fields."""
    capabilities = place.info.capabilities
    if wanted.data is not None and capabilities.data is None:
        call.fields.fault("datarate", call.word("boards.classic-only"))
        call.fields.check()
    try:
        capabilities.timing(wanted.nominal or 0)
    except BadTiming as error:
        call.fields.fault("rate", call.word.error(error))
    try:
        if wanted.data is not None:
            capabilities.data_timing(wanted.data)
    except BadTiming as error:
        call.fields.fault("datarate", call.word.error(error))
    call.fields.check()
    return replace(wanted.mode(capabilities), persistent=True)


def stop(call: Call) -> str:
    return _controlled(call, "stopped", lambda control: control.stop())


def reset(call: Call) -> str:
    return _controlled(call, "was-reset", lambda control: control.reset())


def recover(call: Call) -> str:
    """Recover a line from bus-off; this needs no control of the line."""
    hub = call.desk.link.hub
    place = find_can_line(hub, call.fields.text("line"))
    with hub.open_channel(place.board.id, place.line):
        hub.recover(place.board.id, place.line)
    return call.word("boards.recovered", line=place.address)


def _controlled(call: Call, done: str, do: Callable[[canwire.Control], None]) -> str:
    hub = call.desk.link.hub
    place = find_can_line(hub, call.fields.text("line"))
    with hub.open_control(place.board.id, place.line) as control:
        do(control)
    return call.word(f"boards.{done}", line=place.address)


ACTIONS = {"plug": plug, "unplug": unplug, "up": up, "stop": stop, "reset": reset, "recover": recover}
