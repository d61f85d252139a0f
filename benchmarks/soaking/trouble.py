"""What else goes wrong on a machine: programs and the hub stopped for a while, clocks set, a disk that is full."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections import Counter
from pathlib import Path
from random import Random

from soaking.crowd import PATIENCE_S, Running

_STOPPED_S = 30.0
_HUB_STOPPED_S = 3.0
_HUB_EVERY_S = 120.0
_BESIDE_EVERY_S = 30.0
_NEVER_STOPPED = (
    "dongle",
    "network",
)  # a terminal has no account of what it drops; a network gives silent ones up
_LOCKSTEP = Path(__file__).with_name("lockstep.py")


class Trouble:
    """`look` ends what has lasted long enough; what goes on beside is one thing of each kind."""

    def __init__(self, hub: int, address: str, home: Path, random: Random, done: Counter[str]) -> None:
        self._hub, self._address, self._home = hub, address, home
        self._random, self._done = random, done
        self.stoppable: list[tuple[str, Running]] = []
        self.wrong: list[str] = []
        self._stopped: tuple[Running, float] | None = None
        self._beside: dict[str, Running] = {}
        self._digest = ""
        self._rests_until: dict[str, float] = {}

    def look(self) -> None:
        if self._stopped is not None and time.monotonic() >= self._stopped[1]:
            self.go_on()
        for what in [what for what, running in self._beside.items() if running.process.poll() is not None]:
            self._ended(what)

    def go_on(self) -> None:
        """Whoever is stopped goes on."""
        if self._stopped is not None:
            self._stopped[0].process.send_signal(signal.SIGCONT)
            self._stopped = None

    def end(self) -> None:
        self.go_on()
        for what, running in list(self._beside.items()):
            running.process.wait(2 * PATIENCE_S)
            self._ended(what)

    def stop(self) -> None:
        """A program does nothing for half a minute."""
        able = [running for kind, running in self.stoppable if kind not in _NEVER_STOPPED]
        if self._stopped is None and able:
            running = self._random.choice(able)
            running.process.send_signal(signal.SIGSTOP)
            self._stopped = running, time.monotonic() + _STOPPED_S
            self._done["programs stopped for 30 s"] += 1

    def stop_hub(self) -> None:
        if not self._is_time("hub", _HUB_EVERY_S):
            return
        os.kill(self._hub, signal.SIGSTOP)
        time.sleep(_HUB_STOPPED_S)
        os.kill(self._hub, signal.SIGCONT)
        self._done["hub stopped for 3 s"] += 1

    def set_clock(self) -> None:
        """The hub's clock of the wall jumps by a day."""
        os.kill(self._hub, signal.SIGUSR1)
        self._done["hub's clock set by a day"] += 1

    def full_disk(self) -> None:
        """A recorder that has no room for its log, not even for the head of a file without entries."""
        self._begin("full disk", ["-m", "canwire", "record", "--hub", self._address, "HW0:1", "/dev/full",
                                  "--format", "asc", "--for", "5s"])  # fmt: skip

    def lockstep(self) -> None:
        self._begin("lockstep", [str(_LOCKSTEP), str(self._home)])

    def _begin(self, what: str, words: list[str]) -> None:
        if what not in self._beside and self._is_time(what, _BESIDE_EVERY_S):
            log = self._home / f"{what.replace(' ', '-')}.log"
            self._beside[what] = Running([sys.executable, *words], log, self._address)

    def _is_time(self, what: str, every_s: float) -> bool:
        now = time.monotonic()
        if now < self._rests_until.get(what, now):
            return False
        self._rests_until[what] = now + every_s
        return True

    def _ended(self, what: str) -> None:
        running = self._beside.pop(what)
        status, told = running.process.wait(), b""
        if running.process.stdout is not None:
            told = running.process.stdout.read()
        running.end()
        self._done[f"{what}: runs"] += 1
        said = running.log.read_text()
        if what == "full disk" and (status != 2 or "No space left" not in said or "Traceback" in said):
            self.wrong.append(f"full disk: status {status}: {said[-500:]}")
        if what == "lockstep":
            digest = told.decode().strip()
            self._digest = self._digest or digest
            if status or digest != self._digest:
                self.wrong.append(
                    f"lockstep: status {status}, {digest}, before {self._digest}: {said[-500:]}"
                )
