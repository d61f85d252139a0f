"""`canwire pace`: how quickly a lockstep hub's time passes, by the wall clock.

canwire pace            what it is
canwire pace 1          as the clock; 0.1: a tenth as quickly, 10: ten times
canwire pace free       as quickly as the programs compute
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack

from canwire import WrongState
from canwire.commands.shared_hub import add_hub_argument, connected


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument(
        "factor", nargs="?", metavar="FACTOR|free", type=_factor, help="seconds that pass in one of the clock"
    )
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Set the pace if a factor is given, and print the pace. Raises WrongState for a hub not in lockstep."""
    with ExitStack() as closing:
        hub = connected(arguments, "pace", closing)
        if hub.time != "lockstep":
            raise WrongState(f"a pace is for hubs in lockstep, this one's time is {hub.time}")
        if arguments.factor is not None:
            hub.set_pace(arguments.factor or None)
        state = hub.time_state()
    print(f"{pace_text(state.pace)}, {state.now_ns / 1e9:.9f} s have passed")
    return 0


def pace_text(pace: float) -> str:
    """Return the pace as text."""
    return (
        f"time passes {pace:g} times as quickly as the clock" if pace else "time passes as quickly as it can"
    )


def _factor(text: str) -> float:
    """Return the factor in the text; "free" is 0."""
    if text == "free":
        return 0.0
    try:
        factor = float(text)
    except ValueError:
        factor = 0.0
    if not factor > 0:
        raise argparse.ArgumentTypeError(f"{text!r}: a number above 0, or free")
    return factor
