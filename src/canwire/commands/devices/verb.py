"""`canwire devices`: list the boards of the hub, their lines, and the programs that use them.

canwire devices            a tree for people
canwire devices --json     one object with everything: identity, capabilities, settings, counters
canwire devices --network  hubs offered to other machines, by this machine or at another endpoint
"""

from __future__ import annotations

import argparse
import json
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import canwire
from canwire import (
    ErrorKind,
    ErrorState,
    LineInfo,
    format_rates,
    format_setter,
)
from canwire.commands.console import complain
from canwire.commands.devices.facts import board_facts, time_facts
from canwire.commands.devices.uses import (
    Found,
    LinUse,
    Use,
    boards_of,
    conflicts_among,
    errors_by_kind,
    lateness_among,
)
from canwire.commands.lin.line import mode_text
from canwire.commands.network.offers import print_offers
from canwire.commands.shared_hub import add_hub_argument
from canwire.commands.shell.colour import GREEN, RED, YELLOW, painted

if TYPE_CHECKING:
    from canwire import TimeState


_STATE = 3  # which of a line's cells


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "--network",
        nargs="?",
        const="tcp/localhost:7449",
        metavar="ENDPOINT",
        help="list the hubs that are offered at ENDPOINT instead (default: tcp/localhost:7449)",
    )
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print the boards of the hub; HubLost if the hub at that address does not answer."""
    if arguments.network is not None:
        return print_offers(arguments.network, as_json=arguments.json)
    with ExitStack() as closing:
        hub = closing.enter_context(canwire.connect(arguments.hub, name="canwire devices", timed=False))
        if not hub.address:
            complain(
                "no hub is running; this is what a program finds by itself (`canwire serve` starts a shared one)"
            )
        found = list(boards_of(hub))
        if arguments.json:
            boards = [board_facts(board, states) for board, states in found]
            facts: dict[str, Any] = {"hub": hub.address, "time": hub.time, "boards": boards}
            if hub.time == "lockstep":
                facts["lockstep"] = time_facts(hub.time_state())
            facts["conflicts"] = [str(conflict) for conflict in conflicts_among(found)]
            print(json.dumps(facts, indent=2))
        else:
            print(*(tree(found) or ["no boards; `canwire plug usb-to-can-fd` plugs one in"]), sep="\n")
            if hub.time == "lockstep":
                print(*time_text(hub.time_state()), sep="\n")
            for conflict in conflicts_among(found):
                print(painted(f"! {conflict}", RED))
            for late in sorted(lateness_among(found)):
                print(painted(f"! {late}", RED))
    return 0


def time_text(state: TimeState) -> list[str]:
    """Lockstep mode as text: the programs, what each waits for, and why the time does not advance."""
    shown = [f"{_seconds(state.now_ns)} of one time for {len(state.programs)} threads of programs"]
    if state.pace:
        shown.append(f"  held to {state.pace:g} times the clock (canwire pace)")
    for one in state.programs:
        until = "a signal" if one.until_ns is None else _seconds(one.until_ns)
        shown.append(f"  {one.name}, thread {one.thread}: {f'waits for {until}' if one.waits else 'runs'}")
    return [*shown, *([painted(f"! {state.standstill}", RED)] if state.standstill else [])]


def _seconds(time_ns: int) -> str:
    return f"{time_ns / 1e9:.9f} s"


def tree(found: list[Found]) -> list[str]:
    """Text: a line for each board, two for each of its lines, with columns aligned over all boards."""
    cells = [
        line_cells(index, line, status)
        for board, states in found
        for index, (line, status) in enumerate(zip(board.lines, states, strict=True))
    ]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    rows = iter(cells)
    shown = []
    for board, states in found:
        words = [board.hardware_id, board.kind, board.description]
        if board.resources:
            words.append(", ".join(f"{what} {which}" for what, which in board.resources))
        shown.append("  ".join(words))
        for status in states:
            padded = [cell.ljust(width) for cell, width in zip(next(rows), widths, strict=True)]
            padded[_STATE] = painted(padded[_STATE], colour_of(status))
            shown.append(f"  {'  '.join(padded).rstrip()}")
            shown.append(f"      {counters_text(status)}; {holders_text(status)}")
            if not isinstance(status, LinUse) and status.obstacle:
                shown.append(painted(f"      ! {status.obstacle}", RED))
    return shown


def line_cells(index: int, line: LineInfo, status: Use) -> tuple[str, ...]:
    """The identity and the state of a line, in columns."""
    where = f":{index}", line.name, line.bus or "-"
    initialised = status.status.initialised if isinstance(status, LinUse) else status.initialised
    if not initialised:
        return *where, "not initialised", "", "", "", ""
    if isinstance(status, LinUse):
        lin = status.status
        return *where, lin.state.name.lower(), mode_text(lin), "", "", f"load {lin.load:.1f} %"
    state = ErrorState(status.state).name.lower().replace("_", " ")
    return (
        *where,
        "shorted" if status.coupling_fault else state,
        format_rates(status.mode),
        f"TEC {status.tec}",
        f"REC {status.rec}",
        f"load {status.load:.1f} %",
    )


def colour_of(status: Use) -> str:
    """Green for a line that works, yellow for one with errors, red for one that cannot communicate."""
    if isinstance(status, LinUse):
        return GREEN if status.status.running else ""
    if status.coupling_fault or status.state == ErrorState.BUS_OFF:
        return RED
    if not status.running:
        return ""
    return GREEN if status.state == ErrorState.ERROR_ACTIVE else YELLOW


def counters_text(status: Use) -> str:
    """All counters of a line, lost frames included."""
    if isinstance(status, LinUse):
        lin = status.status
        kinds = ", ".join(f"{count} {name}" for name, count in errors_by_kind(lin).items() if count)
        return (
            f"headers {lin.headers}, sent {lin.frames_sent}, received {lin.frames_received}, "
            f"errors {sum(lin.errors)}{f' ({kinds})' if kinds else ''}, lost {lin.lost}"
        )
    last = f" (last {ErrorKind(status.last_error).name})" if status.errors else ""
    return (
        f"sent {status.frames_sent}, received {status.frames_received}, errors {status.errors}{last}, "
        f"lost {status.lost}, refused {status.refused}"
    )


def holders_text(status: Use) -> str:
    """The programs that use a line."""
    exclusive = " (exclusive)" if status.exclusive else ""
    if isinstance(status, LinUse):
        monitors = f"{status.status.monitors} monitor{'' if status.status.monitors == 1 else 's'}"
        return f"{monitors}{exclusive}, control {status.control_holder or 'free'}"
    channels = f"{status.channels} channel{'' if status.channels == 1 else 's'}"
    setter = f", {format_setter(status)}" if status.initialised else ""
    return (
        f"{channels}{exclusive}, control {status.control_holder or 'free'}, "
        f"cyclic list {status.scheduler_holder or 'free'}{setter}"
    )
