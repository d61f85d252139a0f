"""`canwire fault`: inject a fault into a bus of the hub, for every program that uses it.

canwire fault can0 flip --id 123 --bit 20 --times 3    the next three frames 123 are disturbed
canwire fault can0 inject crc --times 0                every frame, until Ctrl-C
canwire fault can0 noise --rate 1e-4 --for 2           bits read wrong, for two seconds
canwire fault can0 short --for 0.01                    the wires touch for 10 ms
canwire fault can0 unplug HW000001:1                   pull a line's plug, until Ctrl-C
canwire fault can0 babble --id 0                       a node that keeps all other nodes from sending
canwire fault can0 hold dominant --at eof:2 --id 123   a level where and when it matters
canwire fault can0 drift HW000001:0 20000 --stay       leave it so, and end immediately
canwire fault can0 --list                              the faults of all programs, with the program that set each
canwire fault can0 --clear                             remove the faults that --stay left
canwire fault can0 flip --help                         the options of one kind

The command runs until the fault is used up (--times), its time is over (--for) or Ctrl-C. It then removes the fault and
reports how often it occurred. With --stay it ends immediately, and the fault remains until it is used up or cleared.
"""

from __future__ import annotations

import argparse
import json
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING

import msgspec

from canwire import BadValue, HubError, Unsupported
from canwire.commands.fault.kinds import KINDS
from canwire.commands.shared_hub import add_hub_argument, connected

if TYPE_CHECKING:
    from canwire import FaultInfo, Hub, HubBus, HubFault, HubLinBus


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("bus", metavar="BUS", help="name of a bus of the hub: can0, lin0")
    parser.add_argument("--list", action="store_true", help="show the faults that are there")
    parser.add_argument("--clear", action="store_true", help="end faults that --stay left there")
    parser.add_argument(
        "--everybody", action="store_true", help="with --clear: also those of programs that still run"
    )
    parser.add_argument("--json", action="store_true", help="print JSON, one object a line")
    add_hub_argument(parser)
    kinds = parser.add_subparsers(metavar="KIND", dest="kind", title="kinds of faults")
    for name, kind in KINDS.items():
        sub = kinds.add_parser(name, help=kind.help, description=kind.help)
        kind.add_arguments(sub)
        sub.add_argument(
            "--for", dest="lasting", type=float, metavar="SECONDS", help="end it after this time"
        )
        sub.add_argument("--stay", action="store_true", help="leave the fault active, and end immediately")
        sub.add_argument(
            "--json", action="store_true", default=argparse.SUPPRESS, help="print JSON, one object a line"
        )
        add_hub_argument(sub, again=True)


def run(arguments: argparse.Namespace) -> int:
    """Set a fault and see it through, or list or clear them; BadValue, NoSuchBoard, Unsupported, HubError."""
    if sum((arguments.list, arguments.clear, arguments.kind is not None)) != 1:
        raise BadValue(
            "fault: a KIND, --list or --clear; `canwire fault --help` shows them"
            if arguments.kind is None
            else f"fault: {arguments.kind} without --list and --clear"
        )
    with ExitStack() as closing:
        hub = connected(arguments, "fault", closing)
        if arguments.list:
            _list(hub, arguments)
        elif arguments.clear:
            _clear(hub, arguments)
        else:
            _see_through(hub, arguments)
    return 0


def _bus(hub: Hub, name: str) -> HubBus | HubLinBus:
    """Of either kind; raises NoSuchBoard, or Unsupported for a real adapter's."""
    with suppress(Unsupported):
        return hub.bus(name)
    return hub.lin_bus(name)


def _list(hub: Hub, arguments: argparse.Namespace) -> None:
    there = _bus(hub, arguments.bus).faults.list()
    for info in there:
        print(_json("there", info) if arguments.json else _line(info))
    if not there and not arguments.json:
        print(f"{arguments.bus}: no faults")


def _clear(hub: Hub, arguments: argparse.Namespace) -> None:
    ended = _bus(hub, arguments.bus).faults.clear(left=True, everybody=arguments.everybody)
    if arguments.json:
        print(json.dumps({"event": "cleared", "bus": arguments.bus, "ended": ended}))
    else:
        print(f"{arguments.bus}: {ended} {'fault' if ended == 1 else 'faults'} ended")


def _see_through(hub: Hub, arguments: argparse.Namespace) -> None:
    """Set the fault; unless it is to stay, wait for its end and say what it did."""
    fault = KINDS[arguments.kind].set(_bus(hub, arguments.bus), arguments)
    if arguments.stay:
        _tell("set", "set, and stays", fault.info(), arguments.json)
        return
    try:
        _tell("set", "set", fault.info(), arguments.json)
        fault.wait()
    finally:
        _tell_end(fault, arguments.json)


def _tell(event: str, said: str, info: FaultInfo, as_json: bool) -> None:
    print(_json(event, info) if as_json else f"{info.bus}: {info.text}: {said}", flush=True)


def _tell_end(fault: HubFault, as_json: bool) -> None:
    """Take it back, and say what it did; if the hub is gone, the error that says so is on its way already."""
    with suppress(HubError):
        fault.cancel()
        info = fault.info()
        often = "once" if info.struck == 1 else f"{info.struck} times"
        print(
            _json("over", info) if as_json else f"{info.bus}: struck {often}; {info.over or 'taken back'}",
            flush=True,
        )


def _line(info: FaultInfo) -> str:
    left = info.over or ("no end" if info.times_left is None else f"{info.times_left} left")
    stays = ", stays" if info.persistent else ""
    return f"{info.number:>4}  {info.text}; struck {info.struck}, {left}; set by {info.setter}{stays}"


def _json(event: str, info: FaultInfo) -> str:
    return json.dumps({"event": event, **msgspec.structs.asdict(info)})
