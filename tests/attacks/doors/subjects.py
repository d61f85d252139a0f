"""What is attacked: every public callable, with arguments that it takes.

A subject is made anew whenever the last call may have changed it, so that each call meets something healthy.
"""

from __future__ import annotations

import inspect
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from typing import Any

import canwire

_folder = cache(tempfile.TemporaryDirectory)  # for all files that are written

# what a parameter of this name takes; whoever takes something else under it stands in SPECIAL
USUAL: dict[str, Callable[[], Any]] = {
    "id": lambda: 0x123,
    "frame_id": lambda: 0x123,
    "data": lambda: b"\x11\x22",
    "frame": lambda: canwire.Frame(0x123, b"\x11\x22"),
    "frames": lambda: [canwire.Frame(0x123, b"\x11\x22")],
    "records": lambda: canwire.frames_to_array([canwire.Frame(0x123, b"\x11")]),
    "text": lambda: "123#1122",
    "line": lambda: "(1.000000) can0 123#1122",
    "time_ns": lambda: 2_000_000_000,
    "seconds": lambda: 0.001,
    "within": lambda: 0.001,
    "limit": lambda: 2,
    "callback": lambda: lambda *_: None,
    "name": lambda: "other",
    "levels": lambda: "010",
    "bit": lambda: 20,
    "at": lambda: 20,
    "length": lambda: 8,
    "dlc": lambda: 8,
    "fd": lambda: False,
    "path": lambda: Path(_folder().name) / "trace.vcd",
    "bit_error_rate": lambda: 0.001,
    "event": lambda: canwire.BusEvent(canwire.EventKind.ERROR),
}
SPECIAL: dict[str, dict[str, Callable[[], Any]]] = {
    "BitTiming": {"prescaler": lambda: 1, "tseg1": lambda: 5, "tseg2": lambda: 2, "sjw": lambda: 1},
    "BitLayout": {"frame": USUAL["frame"]},
    "Acceptance": {"pairs": lambda: ((0x100, 0x700),)},
    "LinFrame": {"id": lambda: 0x10},
    "BusEvent": {"kind": lambda: canwire.EventKind.ERROR},
    "linmsg_of_record": {"record": lambda: bytes(80)},
    "record_of_linmsg": {"message": lambda: bytes(80)},
    "format_log_line": {"line": lambda: canwire.parse_log_line("(1.000000) can0 123#1122")},
    "format_candump_line": {"line": lambda: canwire.parse_log_line("(1.000000) can0 123#1122")},
    "format_lin_frame": {"frame": lambda: canwire.LinFrame(0x10, b"\x01")},
    "format_lin_log_line": {"line": lambda: canwire.parse_lin_log_line("(1.000000) lin0 10#01")},
    "parse_candump_line": {"text": lambda: "  can0  123   [2]  11 22"},
    "parse_lin_frame": {"text": lambda: "10#01"},
    "parse_lin_log_line": {"line": lambda: "(1.000000) lin0 10#01"},
    "parse_slcan_frame": {"line": lambda: b"t12321122"},
    "lin_checksum": {"data": lambda: b"\x01"},
    "protected_id": {"id": lambda: 0x10},
}
NEEDED: dict[str, list[str]] = {}  # of each callable that was asked for, what has no default
# compiled constructors tell inspect nothing
SIGNATURES = {
    "Frame": (
        "id",
        "data",
        "extended",
        "remote",
        "fd",
        "bit_rate_switch",
        "error_state_indicator",
        "dlc",
        "timestamp_ns",
    ),
    "BitLayout": ("frame", "fd_mode", "error_passive"),
    "SlcanReader": ("fd",),
}
# fmt: off
VALUES = (
    "Acceptance", "BitLayout", "BitTiming", "BusEvent", "Frame", "Lab", "LinFrame", "SlcanReader", "decode_error_frame",
    "dlc_to_length", "encode_error_frame", "format_candump_line", "format_frame", "format_lin_frame",
    "format_lin_log_line", "format_log_line", "format_slcan_frame", "frames_to_array", "length_to_dlc", "lin_checksum",
    "linmsg_of_record", "parse_candump_line", "parse_frame", "parse_lin_frame", "parse_lin_log_line", "parse_log_line",
    "parse_slcan_frame", "protected_id", "record_of_linmsg",
)
# fmt: on
Find = Callable[[ExitStack], Callable[..., Any]]


def arguments_of(name: str, function: Callable[..., Any]) -> dict[str, Any]:
    """What this callable needs at least; parameters with a default are named with it."""
    last = name.rpartition(".")[2]
    special = SPECIAL.get(last, {})
    if last in SIGNATURES:
        return {
            each: special.get(each, USUAL.get(each, bool))()
            for each in SIGNATURES[last]
            if each in ("id", "data", "frame")
        }
    if name not in NEEDED:
        NEEDED[name] = [
            parameter.name
            for parameter in inspect.signature(function).parameters.values()
            if parameter.kind not in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD)
            and parameter.default is parameter.empty
        ]
    return {each: special.get(each, USUAL.get(each, str))() for each in NEEDED[name]}


def parameters_of(name: str, function: Callable[..., Any]) -> list[str]:
    last = name.rpartition(".")[2]
    if last in SIGNATURES:
        return list(SIGNATURES[last])
    return list(inspect.signature(function).parameters)


# things with methods, each made by a function that tells the stack how it ends


def lab(stack: ExitStack) -> canwire.Lab:
    return stack.enter_context(canwire.Lab())


def can_bus(stack: ExitStack) -> Any:
    bus = lab(stack).can_bus("can0", bit_rate=500_000, data_bit_rate=2_000_000)
    bus.node("other one")
    return bus


def can_node(stack: ExitStack) -> Any:
    return can_bus(stack).node("engine")


def lin_bus(stack: ExitStack) -> Any:
    return lab(stack).lin_bus("lin0")


def lin_node(stack: ExitStack) -> Any:
    return lin_bus(stack).master()


def hub(stack: ExitStack) -> canwire.Hub:
    return stack.enter_context(canwire.connect(time="virtual"))


def hub_channel(stack: ExitStack) -> Any:
    program = hub(stack)
    place = canwire.find_lines(program, "can0")[0]
    mode = canwire.LineMode(canwire.BitTiming.for_bit_rate(500_000, clock_hz=8_000_000))
    stack.enter_context(canwire.start_line(program, place, mode))
    channel = stack.enter_context(program.open_channel(place.board.id, place.line))
    channel.set_up(canwire.ChannelMode(receive=16, transmit=16))
    channel.activate()
    return channel


THINGS: dict[str, Callable[[ExitStack], Any]] = {
    "Frame()": lambda _stack: canwire.Frame(0x123, b"\x11"),
    "BitLayout()": lambda _stack: canwire.BitLayout(canwire.Frame(0x123, b"\x11")),
    "SlcanReader()": lambda _stack: canwire.SlcanReader(),
    "Lab()": lab,
    "LabBus": can_bus,
    "LabBus.faults": lambda stack: can_bus(stack).faults,
    "LabNode": can_node,
    "LabLinBus": lin_bus,
    "LabLinNode": lin_node,
    "Hub": hub,
    "HubChannel": hub_channel,
}
