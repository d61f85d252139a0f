"""`canwire acan` beside another machine, all of it doubles: machine 2 sends back whatever comes to it.

python -m tests.commands.acan.on_double term 1 2
"""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack
from typing import Any

from canwire.commands import main
from canwire.commands.acan import programs as acan_programs
from canwire.commands.acan.machines import set_up
from canwire.commands.acan.term import Terminal
from tests.commands.acan.double import Wire


def run(words: list[str]) -> int:
    wire = Wire()
    other: Any = wire.driver()
    own = wire.driver()
    set_up(other, 2)

    def send_back() -> None:
        mirror.received()

    mirror = Terminal(other, 2, 1, loop=True, woken=send_back)
    mirror.open()

    def opened(arguments: argparse.Namespace, program: str, closing: ExitStack) -> Any:
        return own

    acan_programs._opened = opened
    return main(["acan", *words])


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
