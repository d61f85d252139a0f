"""`canwire doctor`: find what keeps canwire from working on this machine, and how to repair it.

canwire doctor             everything: core, extras, adapters and rights to them, hubs, limits, clock
canwire doctor --problems  only what must be repaired
canwire doctor --json      an object for each finding, for programs

Nothing is changed, and no adapter is opened. Exit status 1 if something must be repaired.
"""

from __future__ import annotations

import argparse
import json

from canwire.commands.doctor.checks import NOTE, OK, PROBLEM, Finding, examined
from canwire.commands.doctor.gathering import gathered
from canwire.commands.shared_hub import add_hub_argument
from canwire.commands.shell.colour import GREEN, RED, YELLOW, painted

_MARKS = {OK: ("ok", GREEN), NOTE: ("note", YELLOW), PROBLEM: ("PROBLEM", RED)}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("--problems", action="store_true", help="show only what must be repaired")
    parser.add_argument("--json", action="store_true", help="print JSON, an object for each finding")
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print what is found; 1 if something must be repaired."""
    found = examined(gathered(arguments.hub))
    for finding in found:
        if finding.level == PROBLEM or not arguments.problems:
            print(json.dumps(finding._asdict()) if arguments.json else format_finding(finding))
    problems = sum(finding.level == PROBLEM for finding in found)
    if not arguments.json:
        print(f"{problems} problem{'s' * (problems != 1)}" if problems else "no problems")
    return 1 if problems else 0


def format_finding(finding: Finding) -> str:
    """`PROBLEM  serial ports  /dev/ttyUSB0: this user may not open it`, and below it what to do."""
    word, colour = _MARKS[finding.level]
    text = f"{painted(f'{word:<7}', colour)}  {finding.subject:<12}  {finding.text}"
    return f"{text}\n{'':<23}-> {finding.remedy}" if finding.remedy else text
