"""Calls with too many, missing or unknown arguments: which one it is, and how the call is written.

Python's own error counts places, and leaves open which value was not expected and what its name is. A wrapper answers
in its place. It costs a tenth of a microsecond, so that what is called for each frame has none: a lab node's `receive`,
a channel's `send` and `receive`, and what is compiled. A node's `send` has `*wrong` instead (boards/can/sending.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import wraps
from typing import TYPE_CHECKING, Any, TypeVar

from canwire.values.arguments import unknown_argument
from canwire.values.checks import shown

if TYPE_CHECKING:
    from inspect import Parameter

CallT = TypeVar("CallT", bound=Callable[..., Any])

_PLACE = 'place = canwire.find_lines(hub, "can0")[0]'
_MODE = "canwire.LineMode(canwire.BitTiming.for_bit_rate(500_000, clock_hz=80_000_000))"
EXAMPLES: dict[str, dict[str, str]] = {
    "": {
        "connect": 'canwire.connect(), or canwire.connect(time="virtual") for a hub of this program alone',
        "open_log": 'canwire.open_log("drive.blf")',
        "create_log": 'canwire.create_log("drive.blf")',
        "load_database": 'canwire.load_database("engine.dbc")',
        "find_lines": 'canwire.find_lines(hub, "can0")',
        "start_line": f"{_PLACE}; canwire.start_line(hub, place, {_MODE})",
        "campaign": "@canwire.campaign(load=[0.1, 0.5]) before def run(lab, load)",
    },
    "Lab": {
        "__init__": 'canwire.Lab(), or canwire.Lab(time="real")',
        "can_bus": 'lab.can_bus("can0", bit_rate=500_000)',
        "lin_bus": 'lab.lin_bus("lin0", bit_rate=19_200)',
        "run_for": "lab.run_for(0.5), in seconds",
        "run_until": "lab.run_until(5_000_000), in nanoseconds",
        "run_until_idle": "lab.run_until_idle()",
    },
    "LabBus": {"node": 'bus.node("engine")'},
    "LabLinBus": {"master": 'bus.master("master")', "slave": 'bus.slave("seat")'},
    "CanBenchNode": {"expect": "node.expect(0x123, within=1.0)"},
    "LinBenchNode": {"send": 'master.send(canwire.LinFrame(0x10, b"\\x11"))'},
    "LabFaults": {
        "flip": "faults.flip(bit=20, frame_id=0x123)",
        "inject": 'faults.inject("crc")',
        "noise": "faults.noise(0.001)",
        "disconnect": "faults.disconnect(node)",
        "reconnect": "faults.reconnect(node)",
        "short": "faults.short(), and faults.clear_short()",
    },
    "CanBusFaults": {
        "flip": 'hub.bus("can0").faults.flip(bit=20, frame_id=0x123)',
        "inject": 'hub.bus("can0").faults.inject("crc")',
    },
    "Hub": {
        "board": 'hub.board("usb-to-can-fd")',
        "bus": 'hub.bus("can0")',
        "plug": 'hub.plug("usb-to-can-fd")',
        "open_channel": f"{_PLACE}; hub.open_channel(place.board.id, place.line)",
        "open_control": f"{_PLACE}; hub.open_control(place.board.id, place.line)",
    },
    "HubChannel": {"set_up": "channel.set_up(canwire.ChannelMode(receive=1024, transmit=256))"},
    "Control": {
        "initialise": f"control.initialise({_MODE})",
        "start": "control.start()",
    },
    "Database": {
        "encode": 'db.encode("EngineData", {"EngineSpeed": 1500})',
        "decode": "db.decode(frame), with a canwire.Frame",
        "message": 'db.message("EngineData")',
    },
    "LineMode": {"__init__": _MODE},
    "ChannelMode": {"__init__": "canwire.ChannelMode(receive=1024, transmit=256)"},
}
"""Functions by the class that has them ("": the door's), each with a call that is right."""


def answers_wrong_calls(function: CallT, kind: str = "", name: str = "") -> CallT:
    """Wrap a function: a wrong call raises a TypeError with the row of the table; its own errors are unchanged."""
    name = name or function.__name__

    @wraps(function)
    def call(*given: Any, **named: Any) -> Any:
        try:
            return function(*given, **named)
        except TypeError as error:
            if error.__traceback__ is not None and error.__traceback__.tb_next is not None:
                raise  # from within
            raise wrong_call(function, kind, name, given, named) from None

    return call  # type: ignore[return-value]  # the same to callers


def wrong_call(
    function: Callable[..., Any], kind: str, name: str, given: tuple[Any, ...], named: Iterable[str]
) -> TypeError:
    """The mistake in a call that Python has refused: too many arguments, an unknown name, or too few arguments."""
    from inspect import signature  # for mistakes alone

    parameters = [one for one in signature(function).parameters.values() if one.name != "unknown"]
    if kind:
        parameters, given = parameters[1:], given[1:]
    call, example = f"{kind if name == '__init__' else name}()", EXAMPLES[kind][name]
    unknown = [one for one in named if all(one != each.name for each in parameters)]
    if unknown:
        return TypeError(f"{unknown_argument(call, unknown, function)}; for example {example}")
    return TypeError(f"{call}: {_misfit(parameters, given, named)}; for example {example}")


def _misfit(parameters: list[Parameter], given: tuple[Any, ...], named: Iterable[str]) -> str:
    placed = [one for one in parameters if one.kind is one.POSITIONAL_OR_KEYWORD]
    by_name = [one.name for one in parameters if one.kind is one.KEYWORD_ONLY]
    if len(given) > len(placed):
        also = f"; by name it takes {', '.join(by_name)}" if by_name else ""
        return f"{shown(given[len(placed)])} is one argument too many{also}"
    twice = next((one.name for one in placed[: len(given)] if one.name in named), "")
    if twice:
        return f"{twice} is given twice"
    needed = [one.name for one in parameters[len(given) :] if one.default is one.empty]
    return f"{next((one for one in needed if one not in named), 'something')} is missing"
