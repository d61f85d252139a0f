"""A hub under attack for as long as you like, and the account of an honest program beside it.

python benchmarks/soak.py --minutes 60        a table of what was done, what it cost, and whether everything balances

One hub in real time; an honest program sends on one line, receives on another, and counts each frame. Around it, in
an order that --seed chooses: clients of a dozen kinds are killed, some of which send rubbish, flood the hub with
requests, read nothing, spoil their events and rings; boards come and go, the bus is shorted; every so often the hub
itself is killed. It ends with an error when a frame is missing, a call fails that should not, or a lease is not given
back.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import random
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from soak_programs import KINDS

import canwire

TIMING = canwire.BitTiming.for_bit_rate(1_000_000, clock_hz=80_000_000)
PATIENCE_S = 20.0


class Served:
    """`canwire serve`, and what it takes."""

    def __init__(self, home: Path) -> None:
        self.address = str(home / "soak.sock")
        command = [sys.executable, "-m", "canwire", "serve", "--time", "real", "--socket", self.address]
        self._log = (home / "hub.log").open("a")
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=self._log, text=True)
        assert self.process.stdout is not None
        assert "canwire hub on" in self.process.stdout.readline()

    def resident_kb(self) -> int:
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(status.split("VmRSS:")[1].split()[0])

    def descriptors(self) -> int:
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def end(self, number: int) -> int:
        self.process.send_signal(number)
        self._log.close()
        return self.process.wait(PATIENCE_S)


class Honest:
    """Sends on one line, receives on another, and counts; a new one for each hub."""

    def __init__(self, address: str) -> None:
        self.hub = canwire.connect(address, name="honest")
        self.board = self.hub.boards()[0].id
        self.sending = self._line(0, canwire.ChannelMode(1, 256, frames=False))
        self.receiving = self._line(1, canwire.ChannelMode(65_536, 0))
        self.sent = self.got = 0
        self.calls_ms: list[float] = []

    def exchange(self, count: int) -> None:
        """So many frames there, and as many calls."""
        for _ in range(count):
            self.sending.send(canwire.Frame(0x10, self.sent.to_bytes(4, "little")), timeout=PATIENCE_S)
            self.sent += 1
            began = time.perf_counter()
            self.hub.line_status(self.board, 0)
            self.calls_ms.append((time.perf_counter() - began) * 1000)
        self.collect()

    def collect(self) -> None:
        """Take what has come until all that was sent is there, in order."""
        while self.got < self.sent:
            frame = self.receiving.receive(PATIENCE_S)
            if frame is None:
                raise AssertionError(f"frame {self.got} of {self.sent} never came: {self.sending.status()}")
            if frame.id == 0x10 and not frame.extended:
                number = int.from_bytes(frame.data, "little")
                assert number == self.got, f"frame {number} came in place of {self.got}"
                self.got += 1

    def balance(self) -> None:
        """sent = delivered + aborted + refused + pending; nothing lost."""
        status = self.sending.status()
        assert status.sent == status.delivered + status.aborted + status.refused + status.pending, status
        assert status.delivered == self.sent, (status, self.sent)
        assert self.receiving.status().lost == 0

    def leases_back(self) -> float:
        """Seconds until nobody holds anything on the other board."""
        other = self.hub.boards()[1].id
        began = time.perf_counter()
        while True:
            status = self.hub.line_status(other, 0)
            if not (status.channels or status.scheduler_holder or status.control_holder):
                return time.perf_counter() - began
            if time.perf_counter() - began > PATIENCE_S:
                raise AssertionError(f"leases of killed clients are still held: {status}")

    def _line(self, line: int, mode: canwire.ChannelMode) -> canwire.HubChannel:
        with contextlib.suppress(canwire.InUse):
            control = self.hub.open_control(self.board, line)
            control.initialise(canwire.LineMode(TIMING))
            control.start()
        channel = self.hub.open_channel(self.board, line)
        channel.set_up(mode)
        channel.activate()
        return channel


class Soak:
    """One run, and its table."""

    def __init__(self, home: Path, seed: int) -> None:
        self.home = home
        self.random = random.Random(seed)
        self.served = Served(home)
        self.honest = Honest(self.served.address)
        self.done: Counter[str] = Counter()
        self.sent = self.got = self.lost = 0
        self.calls_ms: list[float] = []
        self.leases_s: list[float] = []
        self.memory_kb: list[int] = []
        self.descriptors: list[int] = []

    def run(self, minutes: float) -> None:
        actions: list[Callable[[], None]] = [self.storm] * 6 + [
            self.bytes, self.boards, self.wire, self.wire, self.half_messages,
        ]  # fmt: skip
        ends = time.monotonic() + 60 * minutes
        next_death = time.monotonic() + 25
        while time.monotonic() < ends:
            self.random.choice(actions)()
            self.honest.exchange(20)
            if time.monotonic() >= next_death:
                self.hub_dies()
                next_death = time.monotonic() + 25
        self.settle()
        assert self.served.end(signal.SIGTERM) == 0

    def storm(self) -> None:
        """Some programs of all kinds at once, killed in the middle of it."""
        kinds = self.random.sample(sorted(KINDS), 4)
        programs = []
        for kind in kinds:
            command = [sys.executable, "-c", KINDS[kind], self.served.address, kind]
            with Path(self.home, "programs.log").open("w") as said:
                programs.append(subprocess.Popen(command, stdout=subprocess.PIPE, stderr=said))
        for program in programs:
            assert program.stdout is not None
            begun = program.stdout.readline()
            assert begun == b"at it\n", Path(self.home, "programs.log").read_text()
        self.honest.exchange(50)
        for program, kind in zip(programs, kinds, strict=True):
            program.kill()
            program.communicate()
            self.done[f"killed: {kind}"] += 1
        self.leases_s.append(self.honest.leases_back())

    def bytes(self) -> None:
        """Connections that say anything at all."""
        for _ in range(50):
            with socket.socket(socket.AF_UNIX) as wire, contextlib.suppress(OSError):
                wire.connect(self.served.address)
                wire.sendall(self.random.randbytes(self.random.randrange(1, 4000)))
        self.done["random connections"] += 50

    def half_messages(self) -> None:
        wires = [socket.socket(socket.AF_UNIX) for _ in range(50)]
        for wire in wires:
            wire.connect(self.served.address)
            wire.sendall(b"\x40\0\0\0half")
        self.honest.exchange(10)
        for wire in wires:
            wire.close()
        self.done["half messages"] += 50

    def boards(self) -> None:
        """In and out again, with somebody on them."""
        with canwire.connect(self.served.address, name="plugger") as hub:
            for _ in range(10):
                plugged = hub.plug("usb-to-can")
                channel = hub.open_channel(plugged.id, 0)
                channel.set_up(canwire.ChannelMode(64, 64))
                hub.unplug(plugged.hardware_id)
        self.done["boards pulled"] += 10

    def wire(self) -> None:
        """The bus shorted for a moment, with frames on it: they come afterwards."""
        self.honest.hub.short("can0", True)
        for _ in range(5):
            self.honest.sending.send(canwire.Frame(0x10, self.honest.sent.to_bytes(4, "little")))
            self.honest.sent += 1
        self.honest.hub.short("can0", False)
        for line in (0, 1):
            self.honest.hub.recover(self.honest.board, line)
        self.honest.collect()
        self.done["bus shorted"] += 1

    def hub_dies(self) -> None:
        """The account is closed, the hub killed, and everything begun anew on the next one."""
        self.settle()
        self.served.end(signal.SIGKILL)
        began = time.monotonic()
        try:
            while True:
                self.honest.hub.boards()
                assert time.monotonic() - began < PATIENCE_S
        except canwire.HubLost:
            pass
        self.served = Served(self.home)
        self.honest = Honest(self.served.address)
        self.done["hub killed"] += 1

    def settle(self) -> None:
        """Everything of the honest program is there, and the account balances."""
        self.honest.collect()
        self.honest.balance()
        self.sent += self.honest.sent
        self.got += self.honest.got
        self.lost += self.honest.receiving.status().lost
        self.calls_ms += self.honest.calls_ms
        self.memory_kb.append(self.served.resident_kb())
        self.descriptors.append(self.served.descriptors())
        status = self.honest.hub.line_status(self.honest.board, 0)
        self.done["ms of bus time left out"] += status.skipped_ns // 1_000_000
        self.honest.hub.close()

    def table(self) -> list[tuple[str, str]]:
        hundredths = statistics.quantiles(self.calls_ms, n=100)
        leases = sorted(self.leases_s)
        kept_mb = [kb / 1024 for kb in self.memory_kb]
        calls = f"{hundredths[49]:.2f}, {hundredths[98]:.1f}, {max(self.calls_ms):.0f} ms"
        back = f"{statistics.median(leases) * 1000:.1f}, {leases[-1] * 1000:.0f} ms"
        return [
            ("honest frames sent, received in order, lost", f"{self.sent}, {self.got}, {self.lost}"),
            ("honest calls: p50, p99, longest", calls),
            ("leases of killed clients back: median, longest", back),
            ("hub's memory at the end of each life", f"{min(kept_mb):.1f} to {max(kept_mb):.1f} MB"),
            ("hub's descriptors then", f"{min(self.descriptors)} to {max(self.descriptors)}"),
            *((what, str(count)) for what, count in sorted(self.done.items())),
        ]


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=1.0, metavar="N", help="how long (default: 1)")
    parser.add_argument("--seed", type=int, default=0, help="of what is done when (default: 0)")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as home:
        soak = Soak(Path(home), arguments.seed)
        try:
            soak.run(arguments.minutes)
        finally:
            soak.served.process.kill()
            log = Path(home, "hub.log").read_text()
        print(f"| {arguments.minutes:g} minutes, seed {arguments.seed} | |\n|---|---|")
        for what, how in soak.table():
            print(f"| {what} | {how} |")
        print(f"| failures of the hub itself | {log.count('a failure (reported once)')} |")
    return 1 if "a failure (reported once)" in log else 0


if __name__ == "__main__":
    sys.exit(main())
