"""Kinds of faults on the command line: the arguments of each, and the call that sets it."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from canwire import BadValue, HubBus, HubLinBus, Unsupported, parse_frame
from canwire.commands.fault import options as o

if TYPE_CHECKING:
    from canwire import HubFault

Bus = HubBus | HubLinBus
Arguments = argparse.Namespace


class Kind(NamedTuple):
    """One word of `canwire fault BUS`."""

    help: str
    add_arguments: Callable[[argparse.ArgumentParser], None]
    set: Callable[[Bus, Arguments], HubFault]


def _can(bus: Bus) -> Any:
    """The faults of a CAN bus; raises Unsupported."""
    if not isinstance(bus, HubBus):
        raise Unsupported(f"{bus.name} is a LIN bus; its faults are {', '.join((*LIN_KINDS, *_BOTH))}")
    return bus.faults


def _lin(bus: Bus) -> Any:
    """The faults of a LIN bus; raises Unsupported."""
    if not isinstance(bus, HubLinBus):
        raise Unsupported(f"{bus.name} is a CAN bus; its faults are {', '.join((*CAN_KINDS, *_BOTH))}")
    return bus.faults


def _flip(bus: Bus, a: Arguments) -> HubFault:
    bit = int(a.bit) if a.bit.isdigit() else a.bit
    return _can(bus).flip(bit=bit, **o.frames(a), **o.often(a), seen_by=o.seen_by(a), **o.stay(a))


def _inject(bus: Bus, a: Arguments) -> HubFault:
    return _can(bus).inject(a.error, **o.frames(a), **o.often(a), **o.stay(a))


def _noise(bus: Bus, a: Arguments) -> HubFault:
    return _can(bus).noise(a.rate, **o.stay(a))


def _hold(bus: Bus, a: Arguments) -> HubFault:
    faults = _can(bus)
    bits = None if a.bits == 0 else a.bits
    return faults.hold(
        a.level, at=o.at(faults, a), bits=bits, seen_by=o.seen_by(a), **o.often(a), **o.stay(a)
    )


def _play(bus: Bus, a: Arguments) -> HubFault:
    faults = _can(bus)
    return faults.play(a.levels, at=o.at(faults, a), seen_by=o.seen_by(a), **o.often(a), **o.stay(a))


def _glitch(bus: Bus, a: Arguments) -> HubFault:
    faults = _can(bus)
    return faults.glitch(
        a.level, at=o.at(faults, a), from_ns=a.start, width_ns=a.width, seen_by=o.seen_by(a), **o.often(a),
        **o.stay(a),
    )  # fmt: skip


def _move_edge(bus: Bus, a: Arguments) -> HubFault:
    faults = _can(bus)
    place = o.at(faults, a)
    if place is None:
        raise BadValue("move-edge: --at frame:BIT says which edge")
    return faults.move_edge(a.quanta, at=place, to=a.to, seen_by=o.seen_by(a), **o.often(a), **o.stay(a))


def _babble(bus: Bus, a: Arguments) -> HubFault:
    times = None if a.times in (None, 0) else a.times
    frame = parse_frame(a.frame or f"{a.id or '000'}#")
    return _can(bus).babble(frame=frame, gap=a.gap, times=times, **o.stay(a))


def _octet(name: str, *numbers: str) -> Callable[[Bus, Arguments], HubFault]:
    """A LIN fault with these numbers."""

    def begin(bus: Bus, a: Arguments) -> HubFault:
        make = getattr(_lin(bus), name)
        values = (getattr(a, number) for number in numbers)
        frame_id = None if a.id is None else o.lin_id(a.id)
        fault: HubFault = make(*values, frame_id=frame_id, **o.often(a), **o.stay(a))
        return fault

    return begin


CAN_KINDS = {
    "flip": Kind("invert one bit of frames", o.for_flip, _flip),
    "inject": Kind("provoke a stuff, form, crc, bit or ack error", o.for_inject, _inject),
    "noise": Kind("everybody reads bits wrong by chance", o.for_noise, _noise),
    "hold": Kind("hold a level for some bits, or as long as the fault is there", o.for_hold, _hold),
    "play": Kind("force one level a bit", o.for_play, _play),
    "glitch": Kind("force a level for some nanoseconds", o.for_glitch, _glitch),
    "move-edge": Kind("have an edge of frames come late, or early", o.for_move_edge, _move_edge),
    "drift": Kind(
        "a line's clock runs fast or slow",
        o.for_drift,
        lambda bus, a: _can(bus).drift(a.line, a.ppm, **o.stay(a)),
    ),
    "rate": Kind(
        "a line runs at a wrong bit rate",
        o.for_rate,
        lambda bus, a: _can(bus).wrong_rate(a.line, a.bit_rate, **o.stay(a)),
    ),
    "cable": Kind(
        "the cable has another length",
        o.for_cable,
        lambda bus, a: _can(bus).cable(a.metres, node_delay_ns=a.node_delay, **o.stay(a)),
    ),
    "babble": Kind("a node sends a frame again and again", o.for_babble, _babble),
}
LIN_KINDS = {
    "checksum": Kind("LIN: wrong checksums", o.for_lin(), _octet("checksum")),
    "no-response": Kind("LIN: the node that would answer stays silent", o.for_lin(), _octet("no_response")),
    "cut": Kind("LIN: responses break off", o.for_lin("octets"), _octet("cut", "octets")),
    "stop-bit": Kind("LIN: a byte's stop bit is dominant", o.for_lin("octet"), _octet("stop_bit", "octet")),
    "flip-octet": Kind(
        "LIN: invert one bit of responses", o.for_lin("octet", "bit"), _octet("flip", "octet", "bit")
    ),
    "parity": Kind("LIN: wrong parity bits", o.for_lin(), _octet("parity")),
    "short-break": Kind("LIN: breaks too short", o.for_lin("bits"), _octet("short_break", "bits")),
    "sync": Kind("LIN: another byte in place of 0x55", o.for_lin("value"), _octet("sync", "value")),
}
_BOTH = {
    "short": Kind("the wires touch (LIN: ground)", o.for_nothing, lambda bus, a: bus.faults.short(**o.stay(a))),
    "unplug": Kind("pull a line's plug", o.for_line, lambda bus, a: bus.faults.disconnect(a.line, **o.stay(a))),
}  # fmt: skip
KINDS = {**CAN_KINDS, **_BOTH, **LIN_KINDS}
