"""A hub under attack for as long as you like, with eight kinds of programs on it, and the account of each.

python benchmarks/soak.py --minutes 60 --output /tmp/soak     table, CSV and picture there, as it goes

One hub in real time. Eight programs (canwire, VCI, ACAN, CANDRV, python-can, SocketCAN, a serial dongle, LIN) send and
receive on can0 and lin0, whose wires are disturbed at random by every kind of fault there is; at the end of each life
of the hub nothing may be missing from their accounts. An honest program on can1 sends, receives, and counts each
frame. Around them, in an order that --seed chooses: programs of the same kinds and hostile ones are killed, boards come
and go, connections say rubbish. Beside all that two processes measure what a call takes and how soon a killed
program's lease is free, and a third how late a bare sleep of 20 ms ends: the machine's own share of both. For the first
two thirds of the time (--life) the hub lives, so that one sees what grows; then it is killed every minute. It ends with
status 1 when a frame is missing or an account does not balance.
"""

from __future__ import annotations

import argparse
import random
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path

from soaking.attacks import Attacks
from soaking.crowd import Crowd, Running
from soaking.figures import Sample, draw, growth, quantile, write_csv
from soaking.honest import Honest, Served
from soaking.meters import Meter
from soaking.services import Services
from soaking.trouble import Trouble

import canwire

_LOOK_S = 10.0
_SHORT_LIFE_S = 60.0


class Soak:
    """One run, and its table."""

    def __init__(self, home: Path, output: Path, seed: int) -> None:
        self.home, self.output = home, output
        self.seed = seed
        self.random = random.Random(seed)
        self.done: Counter[str] = Counter()
        self.kinds: dict[str, Counter[str]] = {}
        self.sent = self.got = self.lost = 0
        self.calls_ms: list[float] = []
        self.leases_ms: list[float] = []
        self.sleeps_ms: list[float] = []
        self.samples: list[Sample] = []
        self.wrong: list[str] = []
        self.lives = 0
        self.began = time.monotonic()

    def run(self, minutes: float, first_life: float) -> None:
        ends = self.began + 60 * minutes
        life_s = 60 * first_life
        while time.monotonic() < ends:
            try:
                self.live(life_s, ends)
            except (AssertionError, OSError, ValueError, canwire.CanwireError):
                self.fail(f"life {self.lives}: {traceback.format_exc()}")
                for process in list(Running.everybody):
                    process.kill()
            life_s = _SHORT_LIFE_S

    def live(self, life_s: float, ends: float) -> None:
        """A hub's life: attacked for so long, then everything must be there. It is killed, but for the last one."""
        self.lives += 1
        served = Served(self.home)
        try:
            honest = Honest(served.address)
            services = Services(
                honest.hub, served.address, self.home, self.done
            )  # there before the first frame
            crowd = Crowd(honest.hub, served.address, self.home)
            trouble = Trouble(served.process.pid, served.address, self.home, self.random, self.done)
            trouble.stoppable = [*crowd.kept.items(), *(("", each) for each in services.stoppable)]
            attacks = Attacks(honest, crowd, trouble, self.home, self.random, self.done)
            meters = [Meter(what, served.address) for what in ("calls", "leases", "sleeps")]
            look = time.monotonic() + _LOOK_S
            until = time.monotonic() + life_s
            while time.monotonic() < until:
                attacks.one()
                honest.exchange(10)
                if time.monotonic() >= look:
                    look = time.monotonic() + _LOOK_S
                    self.sample(served, honest, [meter.take() for meter in meters])
            attacks.end()
            self.sample(served, honest, [meter.take() for meter in meters])
            for meter in meters:
                meter.end()
            self.settle(honest, crowd, services, trouble)
            last = time.monotonic() >= ends
            honest.end(served, signal.SIGTERM if last else signal.SIGKILL)
            self.done["hub killed"] += not last
        finally:
            served.process.kill()

    def sample(self, served: Served, honest: Honest, measured: list[list[float]]) -> None:
        status = honest.hub.line_status(honest.board, 0)
        called, freed, slept = measured
        self.calls_ms += called
        self.leases_ms += freed
        self.sleeps_ms += slept
        minute = (time.monotonic() - self.began) / 60
        self.samples.append(
            Sample(
                minute, self.lives, served.own_kb() / 1024, served.shared_kb() / 1024,
                served.descriptors(), served.threads(),
                len(called), quantile(called, 0.5), quantile(called, 0.99), max(called, default=0.0),
                len(freed), quantile(freed, 0.5), max(freed, default=0.0),
                quantile(slept, 0.99), max(slept, default=0.0), status.skipped_ns // 1_000_000,
            )
        )  # fmt: skip
        print(f"{self.samples[-1]}", flush=True)
        self.write()

    def settle(self, honest: Honest, crowd: Crowd, services: Services, trouble: Trouble) -> None:
        """The accounts of this life."""
        honest.balance()
        self.sent += honest.sent
        self.got += honest.got
        self.lost += honest.receiving.status().lost
        wrong = [*trouble.wrong, *crowd.settle(), *services.settle()]
        for kind, account in crowd.accounts.items():
            self.kinds.setdefault(kind, Counter()).update(account)
        for what in wrong:
            self.fail(f"life {self.lives}: {what}")
        self.done["ms of bus time left out"] += self.samples[-1].skipped_ms

    def fail(self, what: str) -> None:
        self.wrong.append(what)
        minute = (time.monotonic() - self.began) / 60
        print(f"minute {minute:.2f}: {what}", file=sys.stderr, flush=True)

    def write(self) -> None:
        """All there is so far."""
        self.output.mkdir(parents=True, exist_ok=True)
        write_csv(self.samples, self.output / "soak.csv")
        (self.output / "soak.md").write_text(self.table(), encoding="utf-8")

    def table(self) -> str:
        calls, leases, sleeps = self.calls_ms, self.leases_ms, self.sleeps_ms
        rows = [
            ("honest frames sent, received in order, lost", f"{self.sent}, {self.got}, {self.lost}"),
            (f"calls beside the storm ({len(calls)}): p50, p99, longest", _times(calls)),
            (f"leases of killed programs back ({len(leases)}): p50, p99, longest", _times(leases)),
            (f"a bare sleep's lateness beside them ({len(sleeps)}): p50, p99, longest", _times(sleeps)),
            ("hub's own memory over its longest life, in fifths", f"{growth(self.samples, 'memory_mb')} MB"),
            ("rings that it shares with programs, in fifths", f"{growth(self.samples, 'shared_mb')} MB"),
            ("hub's descriptors, in fifths", growth(self.samples, "descriptors")),
            ("hub's threads, in fifths", growth(self.samples, "threads")),
            *((what, str(count)) for what, count in sorted(self.done.items())),
            ("accounts that do not balance, and other failures", str(len(self.wrong))),
            ("failures of the hub itself", str(self.failures())),
        ]
        head = f"| {(time.monotonic() - self.began) / 60:.1f} minutes, seed {self.seed} | |\n|---|---|\n"
        return head + "".join(f"| {what} | {how} |\n" for what, how in rows) + "\n" + self.accounts()

    def accounts(self) -> str:
        columns = ("taken", "delivered", "aborted", "refused", "pending", "line sent", "line received", "got",
                   "waiting", "lost", "turned_away")  # fmt: skip
        head = (
            "| program | handed over | delivered | aborted | refused | pending | sent by its line | received "
            "| read | waiting | lost | turned away |\n"
        )
        rows = "".join(
            f"| {kind} | {' | '.join(str(account[name]) if name in account else '' for name in columns)} |\n"
            for kind, account in self.kinds.items()
        )
        return head + "|---" * 12 + "|\n" + rows

    def failures(self) -> int:
        return (self.home / "hub.log").read_text().count("a failure (reported once)")


def _times(times: list[float]) -> str:
    return f"{quantile(times, 0.5):.2f}, {quantile(times, 0.99):.1f}, {max(times, default=0.0):.0f} ms"


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=1.0, metavar="N", help="how long (default: 1)")
    parser.add_argument(
        "--life", type=float, metavar="N", help="minutes of the hub's first life (default: 2/3)"
    )
    parser.add_argument("--seed", type=int, default=0, help="of what is done when (default: 0)")
    parser.add_argument("--output", type=Path, default=Path("soak"), metavar="FOLDER", help="default: ./soak")
    arguments = parser.parse_args()
    signal.signal(
        signal.SIGINT, signal.default_int_handler
    )  # a script's `&` has it ignored, also in the programs
    with tempfile.TemporaryDirectory() as home:
        soak = Soak(Path(home), arguments.output, arguments.seed)
        try:
            soak.run(arguments.minutes, arguments.life or arguments.minutes * 2 / 3)
        finally:
            for process in Running.everybody:
                process.kill()
            soak.write()
            print(soak.table(), flush=True)
            draw(soak.samples, arguments.output / "soak.svg")
            for what in soak.wrong:
                print(what)
        return 1 if soak.wrong or soak.failures() else 0


if __name__ == "__main__":
    sys.exit(main())
