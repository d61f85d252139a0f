"""The eight kinds of programs of the soak, each of which keeps an account: `python kinds.py KIND ADDRESS PLACE NUMBER`.

It says that it is ready, sends a few frames now and then and reads all that comes. Words on its input: `go`, `stop`
(it sends nothing more), `account` (a line of JSON: what it handed over, what it read, and what its channel says). It
ends with its input.
"""

from __future__ import annotations

import json
import os
import select
import sys
import time
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parent.parent))

from soaking.compiled import COMPILERS, compiled
from soaking.interfaces import KINDS, RATE, Program

_PAUSE_S = 0.1
_FIRST_ID = 0x100  # of program 0; each has one identifier


def command(kind: str, address: str, place: str, number: int, home: Path) -> list[str]:
    """What starts one; those that are compiled are in `home`."""
    if kind in COMPILERS:
        return [*compiled(kind, home), place, str(number)]
    run = [sys.executable, "-m", "canwire", "run", "--hub", address, "--bit-rate", str(RATE)]
    own = [sys.executable, os.path.abspath(__file__), kind, address, place, str(number)]
    return [*run, *own] if kind == "socketcan" else own


class Keeper:
    """Does what its input says, with the account."""

    def __init__(self, program: Program, number: int) -> None:
        self.program = program
        self.id = _FIRST_ID + number
        self.sends = False
        self.taken = self.turned_away = self.got = 0

    def run(self) -> None:
        next_s = 0.0
        while True:
            ready, _, _ = select.select([0], [], [], _PAUSE_S / 2)
            if ready and not self.told(sys.stdin.buffer.raw.readline().decode().strip()):  # type: ignore[attr-defined]
                return
            self.got += self.program.read()
            if self.sends and time.monotonic() >= next_s:
                next_s = time.monotonic() + _PAUSE_S
                took = self.program.send(self.id, self.taken.to_bytes(4, "little"))
                self.taken += took
                self.turned_away += not took

    def told(self, word: str) -> bool:
        self.sends = word == "go" if word in ("go", "stop") else self.sends
        if word == "account":
            self.got += self.program.read()
            own = {"taken": self.taken, "turned_away": self.turned_away, "got": self.got}
            print(json.dumps(own | self.program.account()), flush=True)
        return word != ""


def main(kind: str, address: str, place: str, number: str) -> None:
    program = KINDS[kind](address, place)
    print("at it", flush=True)
    Keeper(program, int(number)).run()


if __name__ == "__main__":
    main(*sys.argv[1:])
