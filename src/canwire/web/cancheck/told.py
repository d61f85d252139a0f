"""The state of CanCheck for the script of the page: JSON for the main window and each window, with the new rows."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from canwire import BadValue, CanwireError
from canwire.web.cancheck.receive import ReceiveWindow
from canwire.web.cancheck.typed import shown_recipe

if TYPE_CHECKING:
    from canwire.web.cancheck.program import CanCheck, Window
    from canwire.web.cancheck.send import SendWindow
    from canwire.web.words import Words

MOST_ROWS = 400  # at a time: what a viewer can look at


def key_of(window: Window) -> str:
    return f"{window.kind}-{window.number:X}"


def told_main(program: CanCheck, word: Words) -> dict[str, Any]:
    """Return the state of the main window. It is only {"running": False} if CanCheck does not run.

    `trouble` is the error that prevented reading the port's settings."""
    try:
        port = program.port
    except BadValue:
        return {"running": False}
    try:
        shown = port.shown()
    except CanwireError as error:
        return {"running": True, "port": port.name, "trouble": word.error(error)}
    return {"running": True, "trouble": "", **asdict(shown)}


def told_window(window: Window, word: Words) -> dict[str, Any]:
    """Return the state of a window without its rows."""
    told: dict[str, Any] = {
        "key": key_of(window),
        "kind": window.kind,
        "number": f"{window.number:X}",
        "port": window.handle.name,
        "log": window.list.log_name,
        "trouble": word.trouble(window.trouble or window.list.trouble),
    }
    try:
        more = _told_receive(window) if isinstance(window, ReceiveWindow) else _told_send(window, word)
    except CanwireError as error:
        return {**told, "trouble": told["trouble"] or word.error(error)}
    return {**told, **more}


def told_rows(window: Window, number: int) -> dict[str, Any]:
    """Return the rows from this number on; `start` is the number of the first one."""
    since = window.list.since(number, MOST_ROWS)
    return {"first": since.first, "start": since.start, "total": since.total, "rows": since.rows}


def _told_receive(window: ReceiveWindow) -> dict[str, Any]:
    rows = window.filter_rows()
    return {
        "events": int(window.mask),
        "code": f"{window.filter.code:08X}",
        "mask": f"{window.filter.mask:08X}",
        "standard": rows.standard,
        "extended": rows.extended,
    }


def _told_send(window: SendWindow, word: Words) -> dict[str, Any]:
    return {
        "given_up": window.given_up,
        "lost": window.echoes.lost,
        "generators": [
            {
                "row": window.generator_row(row),
                "active": row.due_ns is not None,
                "waits": row.waits,
                "trouble": word.trouble(row.trouble),
                "fields": shown_recipe(window.generators.recipe(row.number), window.align),
            }
            for row in window.generators.rows()
        ],
    }
