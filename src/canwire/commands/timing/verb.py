"""`canwire timing`: calculate bit timings from a bit rate, registers or tolerances, and check them.

canwire timing 500000                           one suitable timing
canwire timing 500000 --sample-point 80 --list  every timing, nearest to 80 % first
canwire timing --btr 001C                       explain registers of an SJA1000
canwire timing 500000 --search --tolerance 0.1 --delay-ns 300
canwire timing 500000 --data-bit-rate 2000000   both phases of a CAN FD bus

Can these nodes communicate? Each rule of ISO 11898-1 is printed with its margin:
canwire timing --nodes 500k@80/2M@80 500k@80/2M@80
canwire timing --nodes 500k@75 btr:001C --cable 30 --ppm 100
canwire timing --nodes ecu=500k@87.5/4M@80 tester=500k@75/4M@80   they cannot: status 1
"""

from __future__ import annotations

import argparse
import json
from typing import Any

from canwire import BadTiming, BitTiming, TimingLimits
from canwire.commands.timing import nodes

_CLOCK_HZ = {"sja1000": 8_000_000, "fd": 80_000_000}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("bit_rate", nargs="?", type=int, metavar="BIT/S", help="nominal bit rate")
    parser.add_argument(
        "--bit-rate",
        dest="bit_rate_option",
        type=int,
        metavar="BIT/S",
        help="the same as BIT/S without the option",
    )
    parser.add_argument(
        "--sample-point",
        type=float,
        metavar="PERCENT",
        help="sample point (default: the recommendation of CiA for the rate)",
    )
    parser.add_argument(
        "--sjw", type=int, metavar="QUANTA", help="synchronization jump width (default: the widest allowed)"
    )
    parser.add_argument(
        "--controller",
        choices=sorted(_CLOCK_HZ),
        help="kind of controller (default: sja1000; fd with --data-bit-rate)",
    )
    parser.add_argument(
        "--clock", type=int, metavar="HZ", help="clock of the prescaler; for an SJA1000, half its crystal"
    )
    parser.add_argument("--data-bit-rate", type=int, metavar="BIT/S", help="bit rate of the data phase")
    parser.add_argument(
        "--data-sample-point",
        type=float,
        metavar="PERCENT",
        help="sample point of the data phase (default: 80)",
    )
    parser.add_argument("--btr", metavar="HEX", help="explain the registers BTR0 and BTR1: 001C")
    way = parser.add_mutually_exclusive_group()
    way.add_argument("--list", action="store_true", help="print every timing, not only the best")
    way.add_argument("--search", action="store_true", help="search as the VCI manual does")
    parser.add_argument(
        "--tolerance",
        type=float,
        default=0.1,
        metavar="PERCENT",
        help="with --search: tolerance of the worst oscillator (0.1)",
    )
    parser.add_argument(
        "--delay-ns",
        type=float,
        default=300.0,
        metavar="NS",
        help="with --search: delay of the cable, in both directions (300)",
    )
    parser.add_argument("--json", action="store_true", help="print JSON, an object for each timing")
    nodes.add_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print the timings; BadTiming if there is none."""
    if arguments.bit_rate_option is not None:
        if arguments.bit_rate not in (None, arguments.bit_rate_option):
            raise BadTiming(f"two bit rates, {arguments.bit_rate} and --bit-rate {arguments.bit_rate_option}")
        arguments.bit_rate = arguments.bit_rate_option
    if arguments.nodes:
        return _among(arguments)
    phases = _phases(arguments)
    nominal, data = phases["nominal"], phases.get("data", [])
    tolerance = nominal[0].fd_tolerance(data[0]) if data and not arguments.list else None
    if arguments.json:
        found: dict[str, Any] = {
            name: [_facts(timing) for timing in timings] for name, timings in phases.items()
        }
        if tolerance is not None:
            found["fd_tolerance"] = tolerance
        print(json.dumps(found, indent=2))
        return 0
    for name, timings in phases.items():
        if data:
            print(f"{name} phase:")
        for timing in timings:
            print(_line(timing) if arguments.list else _paragraph(timing))
    if tolerance is not None:
        shown = ", ".join(f"{name} {value:.3%}" for name, value in tolerance.items())
        print(f"oscillators: {min(tolerance.values()):.3%} (conditions {shown})")
    return 0


def _among(arguments: argparse.Namespace) -> int:
    """Check the nodes of --nodes; raises BadTiming if a bit rate or --btr is given, too."""
    if arguments.bit_rate is not None or arguments.btr is not None:
        raise BadTiming("--nodes has each node's timing; leave the bit rate and --btr out")
    return nodes.run(arguments)


def _phases(arguments: argparse.Namespace) -> dict[str, list[BitTiming]]:
    """Return the requested timings: "nominal", and "data" if a data bit rate is given."""
    if arguments.btr is not None:
        if arguments.bit_rate is not None:
            raise BadTiming("give a bit rate or --btr, not both")
        return {"nominal": [_registers(arguments)]}
    if arguments.bit_rate is None:
        raise BadTiming("give a bit rate, or registers with --btr")
    controller = arguments.controller or ("fd" if arguments.data_bit_rate else "sja1000")
    limits = TimingLimits.FD_NOMINAL if controller == "fd" else TimingLimits.SJA1000
    clock_hz = arguments.clock or _CLOCK_HZ[controller]
    phases = {"nominal": _timings(arguments, arguments.bit_rate, arguments.sample_point, clock_hz, limits)}
    if arguments.data_bit_rate is not None:
        if controller != "fd":
            raise BadTiming("an SJA1000 has no data phase; leave --controller out or say fd")
        phases["data"] = _timings(
            arguments, arguments.data_bit_rate, arguments.data_sample_point, clock_hz, TimingLimits.FD_DATA
        )
    return phases


def _timings(
    arguments: argparse.Namespace, bit_rate: int, percent: float | None, clock_hz: int, limits: TimingLimits
) -> list[BitTiming]:
    """Return a list of one timing, or of all timings with --list."""
    sample_point = None if percent is None else percent / 100
    if arguments.list:
        return BitTiming.solutions(bit_rate, clock_hz, limits=limits, sample_point=sample_point)
    if arguments.search:
        return [BitTiming.search(bit_rate, clock_hz, arguments.tolerance / 100, arguments.delay_ns, limits)]
    return [
        BitTiming.for_bit_rate(bit_rate, sample_point, clock_hz=clock_hz, sjw=arguments.sjw, limits=limits)
    ]


def _registers(arguments: argparse.Namespace) -> BitTiming:
    """Return the timing in --btr, four hex digits; raises BadTiming."""
    try:
        btr0, btr1 = bytes.fromhex(arguments.btr)
    except ValueError:
        raise BadTiming(f"--btr {arguments.btr}: four hex digits, BTR0 first, as 001C") from None
    return BitTiming.from_btr(btr0, btr1, 2 * (arguments.clock or _CLOCK_HZ["sja1000"]))


def _facts(timing: BitTiming) -> dict[str, Any]:
    """Return all values of a timing, for --json; `btr` is None if they do not fit into the registers."""
    return {
        "bit_rate": timing.bit_rate,
        "clock_hz": timing.clock_hz,
        "prescaler": timing.prescaler,
        "quanta": timing.quanta,
        "prop": timing.prop,
        "phase1": timing.phase1,
        "tseg1": timing.tseg1,
        "tseg2": timing.tseg2,
        "sjw": timing.sjw,
        "triple_sampling": timing.triple_sampling,
        "sample_point": timing.sample_point,
        "bit_time_ps": timing.bit_time_ps,
        "quantum_ps": timing.quantum_ps,
        "condition_1": timing.condition_1,
        "condition_2": timing.condition_2,
        "tolerance": timing.tolerance,
        "btr": _btr(timing),
    }


def _btr(timing: BitTiming) -> str | None:
    try:
        return "{:02X}{:02X}".format(*timing.to_btr())
    except BadTiming:
        return None


def _line(timing: BitTiming) -> str:
    """Return a timing as one line, for lists."""
    segments = f"tseg1 {timing.tseg1:3d}  tseg2 {timing.tseg2:3d}  sjw {timing.sjw:3d}"
    quality = f"sample {timing.sample_point:7.2%}  oscillators {timing.tolerance:.3%}"
    return f"prescaler {timing.prescaler:3d}  {segments}  {quality}  BTR {_btr(timing) or '-'}"


def _paragraph(timing: BitTiming) -> str:
    """Return a timing as a paragraph."""
    lines = [
        f"{timing.bit_rate} bit/s from {timing.clock_hz} Hz / {timing.prescaler}"
        + (", three samples a bit" if timing.triple_sampling else ""),
        f"  {timing.quanta} quanta of {timing.quantum_ps / 1000:g} ns: SYNC 1, PROP {timing.prop}, "
        f"PHASE1 {timing.phase1}, PHASE2 {timing.tseg2}; SJW {timing.sjw}",
        f"  sample point {timing.sample_point:.2%}, {timing.sample_time_ps / 1000:g} of "
        f"{timing.bit_time_ps / 1000:g} ns",
        f"  oscillators: {timing.tolerance:.3%} (condition 1 {timing.condition_1:.3%}, "
        f"condition 2 {timing.condition_2:.3%})",
    ]
    registers = _btr(timing)
    if registers:
        lines.append(f"  SJA1000 at {timing.clock_hz * 2} Hz: BTR0 {registers[:2]}, BTR1 {registers[2:]}")
    return "\n".join(lines)
