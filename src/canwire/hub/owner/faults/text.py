"""Texts of faults, for lists and reports: `flip bit 20 of 123, seen by all, 3 times`."""

from __future__ import annotations

from canwire.hub.protocol import fault_messages as f
from canwire.values.frame import frame_of_record
from canwire.values.text import format_frame

Parts = tuple[str, ...]


def kind_of(fault: f.Fault) -> str:
    """The method of a program's handle that sets it: `flip`, `move_edge`, `wrong_rate` ..."""
    if isinstance(fault, f.LinFrames):
        return fault.kind
    name = type(fault).__name__
    return "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in name).lstrip("_")


def text_of(fault: f.Fault) -> str:
    """The text of a fault, one line."""
    return ", ".join(part for part in (_what(fault), _viewers(fault), _often(fault)) if part)


def _what(fault: f.Fault) -> str:
    if isinstance(fault, f.Flip):
        what = f"bit {fault.bit}" if isinstance(fault.bit, int) else fault.bit
        return f"flip {what} of {_frames(fault.frame_id, fault.extended)}"
    if isinstance(fault, f.Noise):
        return f"noise, {fault.bit_error_rate:g} of all bits"
    if isinstance(fault, f.LinFrames):
        numbers = "".join(f" {number}" for number in fault.numbers)
        return f"{fault.kind}{numbers} of {_frames(fault.frame_id, None)}"
    return _level(fault) or _copper(fault)


def _level(fault: f.Fault) -> str:
    if isinstance(fault, f.Hold):
        if fault.bits is None:
            return f"hold {fault.level} {_where(fault.at)}, until it is cancelled"
        return (
            f"hold {fault.level} for {fault.bits} {'bit' if fault.bits == 1 else 'bits'} {_where(fault.at)}"
        )
    if isinstance(fault, f.Play):
        return f"play {fault.levels} {_where(fault.at)}"
    if isinstance(fault, f.Glitch):
        return f"glitch {fault.level} for {fault.width_ns:g} ns {_where(fault.at)}"
    if isinstance(fault, f.MoveEdge):
        return f"move the edge to {fault.to} by {fault.quanta} quanta {_where(fault.at)}"
    return ""


def _copper(fault: f.Fault) -> str:
    if isinstance(fault, f.Short):
        return "short" if fault.to == "ground" else f"short to the {fault.to}"
    if isinstance(fault, f.Disconnect):
        return f"disconnect {fault.line}"
    if isinstance(fault, f.Drift):
        return f"drift of {fault.line} by {fault.ppm:+g} ppm"
    if isinstance(fault, f.WrongRate):
        return f"wrong rate of {fault.line}: {fault.bit_rate} bit/s"
    if isinstance(fault, f.Cable):
        delay = f", {fault.node_delay_ns:g} ns more a node" if fault.node_delay_ns else ""
        return f"cable of {fault.length_m:g} m{delay}"
    assert isinstance(fault, f.Babble)
    gap = f", {fault.gap_ns / 1e6:g} ms apart" if fault.gap_ns else ""
    return f"babble {format_frame(frame_of_record(fault.record))}{gap}"


def _where(at: f.At) -> str:
    if at is None:
        return "immediately"
    if isinstance(at, int):
        return f"at {at} ns"
    whose = f", bits of {at.line}" if at.line else ""
    return f"at {at.part} {at.bit} of {_frames(at.frame_id, at.extended)}{whose}"


def _frames(frame_id: int | None, extended: bool | None) -> str:
    kind = {True: "extended ", False: "standard ", None: ""}[extended]
    if frame_id is None:
        return f"any {kind}frame"
    return f"{kind}{frame_id:08X}" if extended or frame_id > 0x7FF else f"{kind}{frame_id:03X}"


def _viewers(fault: f.Fault) -> str:
    seen_by = getattr(fault, "seen_by", ("all",))
    return "" if seen_by == ("all",) else f"seen by {', '.join(seen_by)}"


def _often(fault: f.Fault) -> str:
    if not hasattr(fault, "times") or (isinstance(fault, f.Hold) and fault.bits is None):
        return ""
    times: int | None = fault.times
    return "every time" if times is None else "once" if times == 1 else f"{times} times"
