"""`canwire adapters`: list the real adapters of this machine, each with the command that shares it.

canwire adapters           serial ports, candleLights, and the adapters that python-can finds
canwire adapters --json    the same as JSON, for programs
"""

from __future__ import annotations

import argparse
import json

from canwire import find_adapters
from canwire.commands.console import complain

_NONE = (
    "no adapters found; `canwire doctor` says what this machine lacks, and python-can's interfaces that cannot be "
    "looked for go by python-can:INTERFACE/CHANNEL"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("--json", action="store_true", help="print a list of objects: spec and description")


def run(arguments: argparse.Namespace) -> int:
    """Print the adapters; finding none is not an error."""
    if not arguments.json:
        return list_adapters()
    print(
        json.dumps([{"spec": one.spec, "description": one.description} for one in find_adapters()], indent=2)
    )
    return 0


def list_adapters() -> int:
    """Print each adapter on a line: the command that shares it, then its description."""
    found = [(f'canwire share "{one.spec}" --bit-rate 500000', one.description) for one in find_adapters()]
    width = max((len(line) for line, _ in found), default=0)
    for line, description in found:
        print(f"{line.ljust(width)}  {description}")
    if not found:
        complain(_NONE)
    return 0
