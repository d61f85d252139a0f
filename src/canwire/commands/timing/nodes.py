"""Checks whether nodes can communicate: reads their timings from text and prints the result."""

from __future__ import annotations

import argparse
import json
import re
from typing import Any

from canwire import (
    BadTiming,
    BitTiming,
    ControllerOptions,
    NodeTiming,
    TimingCheck,
    TimingLimits,
    timing_checks,
)

_CLOCK_HZ = 80_000_000
_SJA1000_CLOCK_HZ = 8_000_000
_NS_PER_METRE = 5.0
_PHASE = r"(\d+(?:\.\d+)?)([kM]?)(?:@(\d+(?:\.\d+)?))?(?:,(\d+))?"
_NODE = re.compile(rf"(?:(?P<name>[^=]+)=)?(?:btr:(?P<btr>[0-9A-Fa-f]{{4}})|{_PHASE}(?:/{_PHASE})?)")
_UNITS = {"": 1, "k": 1_000, "M": 1_000_000}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add --nodes and the options for all nodes."""
    group = parser.add_argument_group("can these nodes communicate?")
    group.add_argument(
        "--nodes",
        nargs="+",
        metavar="NODE",
        help="[NAME=]RATE[@PERCENT][,SJW] or [NAME=]RATE[@PERCENT][,SJW]/RATE[@PERCENT][,SJW] with a data phase, "
        "rates as 500k or 4M; or [NAME=]btr:001C. The exit status is 1 if they cannot",
    )
    group.add_argument(
        "--cable",
        type=float,
        default=0.0,
        metavar="METRES",
        help="length of cable between the two farthest nodes (0)",
    )
    group.add_argument(
        "--node-delay-ns",
        type=float,
        default=250.0,
        metavar="NS",
        help="delay of transceivers, node to node (250, the slowest allowed)",
    )
    group.add_argument("--ppm", type=float, default=0.0, help="tolerance of each oscillator (0)")
    group.add_argument(
        "--loop-delay-ns",
        type=float,
        default=0.0,
        metavar="NS",
        help="delay after which a node reads its own bits back (0)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Print each rule with its margin; return 0 if all hold, else 1. Raises BadTiming, BadValue."""
    nodes = [_node(text, number, arguments) for number, text in enumerate(arguments.nodes, 1)]
    for name in ("cable", "node_delay_ns", "ppm"):
        if not 0 <= getattr(arguments, name) < 1e6:
            raise BadTiming(
                f"--{name.replace('_', '-')} {getattr(arguments, name)}: cannot be negative or so large"
            )
    delay_ps = round(1e3 * (arguments.cable * _NS_PER_METRE + arguments.node_delay_ns))
    checks = timing_checks(nodes, delay_ps)
    broken = [check for check in checks if check.exceeded]
    if arguments.json:
        print(json.dumps({"understand": not broken, "checks": [_facts(check) for check in checks]}, indent=2))
    else:
        print(*_report(nodes, checks), sep="\n")
    return 1 if broken else 0


def _node(text: str, number: int, arguments: argparse.Namespace) -> NodeTiming:
    found = _NODE.fullmatch(text)
    if found is None:
        raise BadTiming(
            f"--nodes {text}: RATE@PERCENT, RATE@PERCENT/RATE@PERCENT, or btr:001C; 500k@87.5/4M@80"
        )
    clock_hz = arguments.clock or _CLOCK_HZ
    data = None
    if found["btr"] is not None:
        oscillator_hz = 2 * (arguments.clock or _SJA1000_CLOCK_HZ)
        btr0, btr1 = bytes.fromhex(found["btr"])
        nominal = BitTiming.from_btr(btr0, btr1, oscillator_hz)
    else:
        parts = found.groups()[2:]
        nominal = _phase(parts[:4], clock_hz, TimingLimits.FD_NOMINAL)
        data = _phase(parts[4:], clock_hz, TimingLimits.FD_DATA) if parts[4] else None
    options = ControllerOptions(loop_delay_ns=arguments.loop_delay_ns)
    return NodeTiming(
        found["name"] or f"node {number}", nominal, data, within_ppm=arguments.ppm, options=options
    )


def _phase(parts: tuple[str | None, ...], clock_hz: int, limits: TimingLimits) -> BitTiming:
    number, unit, percent, sjw = parts
    rate = round(float(number or 0) * _UNITS[unit or ""])
    point = None if percent is None else float(percent) / 100
    jump = None if sjw is None else int(sjw)
    return BitTiming.for_bit_rate(rate, point, clock_hz=clock_hz, sjw=jump, limits=limits)


def _report(nodes: list[NodeTiming], checks: list[TimingCheck]) -> list[str]:
    lines = [f"{node.name}: {_rates(node)}, sample points {node.sample_points}" for node in nodes]
    broken = [check for check in checks if check.exceeded]
    lines += [f"! {check}" for check in broken]
    lines += [f"  {_margin(check)}" for check in checks if not check.exceeded]
    if broken:
        return [
            *lines,
            f"no: they would not understand each other ({', '.join(check.what for check in broken)})",
        ]
    tightest = f"; the smallest margin: {_margin(checks[0])}" if checks else ""
    return [*lines, f"yes{tightest}"]


def _rates(node: NodeTiming) -> str:
    data = "" if node.data is None else f", {node.data.bit_rate} after BRS"
    return f"{node.nominal.bit_rate} bit/s{data}"


def _margin(check: TimingCheck) -> str:
    figures = f"{check.figure:.4g} of {check.limit:.4g} {check.unit}"
    return f"{check.what}: {figures}, {check.margin:.4g} {check.unit} left"


def _facts(check: TimingCheck) -> dict[str, Any]:
    return {
        "what": check.what,
        "nodes": check.nodes,
        "exceeded": check.exceeded,
        "figure": check.figure,
        "limit": check.limit,
        "unit": check.unit,
        "margin": check.margin,
        "text": str(check),
    }
