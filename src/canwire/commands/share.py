"""`canwire share`: put real adapters on the hub, so that any number of programs can use them together.

canwire share /dev/ttyUSB0                          a CANBUS dongle or another serial adapter; COM3 on Windows
canwire share socket://192.168.0.7:4001             an adapter at a serial server, or `canwire slcan --tcp`
canwire share "?serial=A123"                        the one with that serial number, wherever it is
canwire share slcan-fd:/dev/ttyACM0                 an adapter that supports CAN FD (CANable's letters)
canwire share python-can:pcan/PCAN_USBBUS1 --bit-rate 250000
canwire share python-can:gs_usb/0 --bit-rate 500000  the first candleLight; its serial number may replace the 0

Where no hub is running, this becomes one until Ctrl-C. With --bit-rate the lines are started and keep running;
without it the first program that uses a line starts it. An adapter that cannot be opened ends this with its reason and
status 1, and none is shared; with --wait the hub waits for it, as it does for one that is pulled out later.
`canwire adapters` lists what is there.
"""

from __future__ import annotations

import argparse
import os
import time
from contextlib import ExitStack
from dataclasses import replace

import canwire
from canwire import (
    BadValue,
    BoardInfo,
    CanwireError,
    ErrorState,
    Event,
    Hub,
    HubLost,
    LinePlace,
    format_rates,
)
from canwire.commands.can_line import line_mode, wanted_by
from canwire.commands.console import complain
from canwire.commands.devices.adapters import list_adapters
from canwire.commands.shared_hub import add_hub_argument
from canwire.commands.shell.ending import signals_call

KINDS = ("slcan", "slcan-fd", "python-can")
PATIENCE_S = 3.0  # for an adapter to say what it is
LOADING_S = 30.0  # for python-can and all that it loads; it says something in any case
_LOOK_S = 0.05


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument(
        "specs",
        nargs="*",
        metavar="SPEC",
        help="/dev/ttyUSB0, COM3, socket://host:port, ?serial=A123, python-can:pcan/PCAN_USBBUS1",
    )
    parser.add_argument("--bit-rate", type=int, metavar="BIT/S", help="start the lines at this rate")
    parser.add_argument("--data-bit-rate", type=int, metavar="BIT/S", help="likewise, CAN FD")
    parser.add_argument("--listen-only", action="store_true", help="start them, but only to listen")
    parser.add_argument("--wait", action="store_true", help="share adapters that are not there yet, too")
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Plug in all adapters, or none; return 2 if one of them cannot be plugged in."""
    specs = [parse_spec(spec) for spec in arguments.specs]
    if not specs:
        return list_adapters()
    address = arguments.hub or os.environ.get("CANWIRE_HUB")
    with ExitStack() as closing:
        try:
            hub = closing.enter_context(canwire.connect(address, name="canwire share", timed=False))
        except HubLost:
            return serve(arguments, specs, address)
        if hub.address:
            return share(hub, specs, arguments)
    return serve(arguments, specs, None)


def serve(arguments: argparse.Namespace, specs: list[tuple[str, str]], address: str | None) -> int:
    """Run a hub with these adapters until SIGTERM or SIGINT; return the exit status."""
    stop = Event(manual_reset=True)
    status = 0

    def ready(introduction: str) -> None:
        nonlocal status
        with canwire.connect(address, name="canwire share", timed=False) as hub:
            status = share(hub, specs, arguments, stop)
        if status:
            stop.set()
        else:
            print(introduction, flush=True)

    try:
        with signals_call(stop.set):
            canwire.serve(address, ready=ready, stop=stop, warn=complain)
    finally:
        stop.close()
    return status


def share(
    hub: Hub, specs: list[tuple[str, str]], arguments: argparse.Namespace, stop: Event | None = None
) -> int:
    """Plug these in, start them if requested, and print their descriptions; returns 1 if one cannot be opened.

    When `stop` is set, it does not wait.
    """
    plugged: list[BoardInfo] = []
    try:
        for kind, port in specs:
            plugged.append(hub.plug(kind, port=port))
        for board in plugged:
            if arguments.bit_rate or arguments.data_bit_rate or arguments.listen_only:
                start(hub, board, arguments)
    except CanwireError:
        for board in plugged:
            hub.unplug(board.hardware_id)
        raise
    begun_s = time.monotonic()
    found = []
    for board in plugged:
        patience_s = LOADING_S if board.kind == "python-can" else PATIENCE_S
        found.append((board, obstacle_of(hub, board, begun_s + patience_s, stop)))
    if any(obstacle for _, obstacle in found) and not arguments.wait:
        for board, obstacle in found:
            hub.unplug(board.hardware_id)
            if obstacle:
                complain(obstacle)
        return 1
    for board, obstacle in found:
        print(introduction_of(hub, board, obstacle), flush=True)
    return 0


def start(hub: Hub, board: BoardInfo, arguments: argparse.Namespace) -> None:
    """Start the board's line so that it keeps running without a program that uses it."""
    wanted = wanted_by(arguments)
    mode = line_mode(board.lines[0].capabilities, wanted)
    if wanted.data is None:
        mode = replace(mode, data_timing=None, long_data=False)
    with hub.open_control(board.id, 0) as control:
        control.initialise(replace(mode, listen_only=arguments.listen_only, persistent=True))
        control.start()


def obstacle_of(hub: Hub, board: BoardInfo, deadline: float, stop: Event | None = None) -> str:
    """Return why the adapter cannot be opened; "" if it runs, or has identified itself and was not started."""
    before, place = board.resources, LinePlace(board, 0)
    while True:
        status = place.status(hub)
        silent = hub.board(board.hardware_id).resources == before
        ended = stop is not None and stop.is_set()
        if ended or (status.running and status.state != ErrorState.STOPPED):
            return ""
        if status.obstacle or not (silent or status.running):
            return status.obstacle
        if time.monotonic() >= deadline:
            return status.obstacle or f"no adapter answers at {dict(before)['Port']}"
        time.sleep(_LOOK_S)


def introduction_of(hub: Hub, board: BoardInfo, obstacle: str) -> str:
    """Return a description of the board in one line."""
    board, status = hub.board(board.hardware_id), LinePlace(board, 0).status(hub)
    said = ", ".join(f"{what} {which}" for what, which in board.resources if which)
    words = [board.hardware_id, board.kind, said]
    if status.running:
        words.append(format_rates(status.mode))
    if obstacle:
        words.append(f"{obstacle}; the hub waits for it")
    return "  ".join(words)


def parse_spec(text: str) -> tuple[str, str]:
    """Return kind and port of `slcan:/dev/ttyUSB0`, `/dev/ttyUSB0`, `python-can:virtual/0`; raises BadValue."""
    kind, colon, port = text.partition(":")
    if colon and kind in KINDS:
        if not port:
            raise BadValue(f"{text!r}: the port is missing behind {kind}:")
        return kind, port
    return "slcan", text
