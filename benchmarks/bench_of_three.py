"""Three machines and a bad network between them, for as long as you like, and every program's account at the end.

python benchmarks/bench_of_three.py --minutes 10 --output /tmp/three     what happened, and the table

The machines are network namespaces of this one, joined by tests/machines/spoiler.py at 400 kB/s each way. The first has
a hub with eight boards, its offer, a source of 100 numbered frames a second, and one who looks when commands come. The
second has python-can, dump, record, and a gateway to a hub of its own; the third VCI, CANDRV, a program in C, one on a
CAN socket under `canwire run`, and one that gives commands, 20 a second. In an order that --seed chooses ways are cut
(one way or both), lose packets or get narrow, hubs and the offer end and programs are killed; what has ended is started
again. At the end every program must be connected, no frame come twice or out of order, none be missing that is not
counted as lost, and no command have reached the bus later than its age of 2 s. It ends with status 1 where that does
not hold. Needs gcc, user namespaces and TUN.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
HERE = Path(__file__).resolve().parent
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from three.kept import Kept  # noqa: E402
from three.program import command  # noqa: E402
from three.trouble import Trouble  # noqa: E402

from tests.machines.namespaces import Machines, machines, why_not  # noqa: E402

_RATE = 400_000.0  # bytes/s
_AGE_S, _SLACK_S = 2.0, 0.5  # what a looker may look late on a busy machine
_PATIENCE_S = 120.0
_FAR = "zenoh://lab/bench?via=tcp/10.77.0.1:7449"
_OWN = [sys.executable, "-m", "canwire"]


class Bench:
    """The programs, and what they came to."""

    def __init__(self, net: Machines, home: Path, output: Path) -> None:
        self.net, self.home, self.output = net, home, output
        self.near, self.second = str(home / "hub.sock"), str(home / "hub-2.sock")
        self.programs: dict[str, Kept] = {}
        self.wrong: list[str] = []
        self.accounts: dict[str, dict[str, Any]] = {}

    def start(self) -> None:
        native = self.home / "native"
        flags = subprocess.run(
            [*_OWN, "native", "vcinpl", "--cflags", "--libs"], check=True, capture_output=True, text=True
        ).stdout.split()
        subprocess.run(["gcc", "-o", native, HERE / "three" / "native.c", *flags], check=True)
        config = str(HERE / "three" / "bench.toml")
        self._keep("hub", 0, [*_OWN, "serve", "--socket", self.near, "--config", config])
        self._keep("hub-2", 1, [*_OWN, "serve", "--socket", self.second, "--config", config])
        self.wait(4)
        listen = ["--listen", "tcp/10.77.0.1:7449", "--realm", "lab", "--name", "bench", "--insecure"]
        self._keep("offer", 0, [*_OWN, "offer", "--hub", self.near, *listen])
        self._speaker("source", 0, self.near, "HW1")
        self._speaker("looker", 0, self.near, "HW2")
        self.wait(4)
        self._speaker("python-can", 1, _FAR, "HW3")
        self._keep(
            "dump", 1, [*_OWN, "dump", "HW3:1", "-l", "--filter", "100:7FF", "--hub", _FAR, "--reconnect"]
        )
        self._keep("record", 1, [*_OWN, "record", "HW4:1", "-", "--format", "candump", "--hub", _FAR])
        self._keep("bridge", 1, [*_OWN, "bridge", "HW7:1", "can0", "--one-way", "--filter", "100:7FF", "--hub", _FAR,
                                 "--to-hub", self.second, "--reconnect"])  # fmt: skip
        self._speaker("looker-2", 1, self.second, "HW2", kind="direct")
        self._speaker("vci", 2, _FAR, "HW4")
        self._speaker("candrv", 2, _FAR, "CID1:")
        self._keep("native", 2, [str(native), "HW6"])
        self._speaker("socketcan", 2, _FAR, "HW7:0")
        self._speaker("commander", 2, _FAR, "HW8")

    def _keep(self, name: str, machine: int, words: list[str], speaks: bool = False) -> None:
        self._kept(name, machine, lambda life: words, speaks)

    def _speaker(self, name: str, machine: int, address: str, place: str, kind: str = "") -> None:
        self._kept(name, machine, lambda life: command(kind or name, address, place, life), True)

    def _kept(self, name: str, machine: int, words: Any, speaks: bool) -> None:
        hub = {0: self.near}.get(machine, self.second if name == "looker-2" else _FAR)
        config = str(HERE / "three" / "bench.toml")  # CANDRV's registry is the program's
        environment = {
            "CANWIRE_HUB": hub,
            "CANWIRE_CONFIG": config,
            "CANWIRE_PYTHON": sys.executable,
            "PYTHONUNBUFFERED": "1",
            "XDG_RUNTIME_DIR": str(self.home),
        }
        on = self.net.all[machine].words
        self.programs[name] = Kept(name, lambda life: on(words(life)), self.home, environment, speaks)

    def wait(self, seconds: float) -> None:
        """Let time pass; what has ended is started again."""
        ends = time.monotonic() + seconds
        while time.monotonic() < ends:
            for program in self.programs.values():
                program.look()
            time.sleep(0.1)

    def settle(self) -> None:
        """The network is well: everybody must be there, and then every account balance."""
        for way in self.net.spoiler.ways.values():
            way.cut, way.loss, way.delay_s, way.rate = False, 0.0, 0.0, _RATE
        waiting, ends = (
            set(self.programs) - {"hub", "hub-2", "offer", "bridge"},
            time.monotonic() + _PATIENCE_S,
        )
        while waiting and time.monotonic() < ends:
            self.wait(2)
            waiting -= {name for name in waiting if self.there(self.programs[name])}
        self.wrong += [
            f"{name} is not connected: {self.programs[name].ends[-1:]}" for name in sorted(waiting)
        ]
        for name in ("source", "commander"):
            self.programs[name].say("stop")
        self.wait(5)
        self.accounts = {
            name: found
            for name, one in self.programs.items()
            if one.speaks and (found := one.account()) is not None
        }
        self._balance()

    def there(self, program: Kept) -> bool:
        """Has it seen frames of the source as it is now?"""
        source = self.programs["source"]
        if not program.speaks:
            return f"100#{source.lives.to_bytes(2, 'little').hex().upper()}" in _tail(program.text)
        found = program.account()
        return found is not None and (program is source or found["life"] == source.lives)

    def _balance(self) -> None:
        given = self.accounts["source"]["given"]
        for name, account in self.accounts.items():
            if account["wrong"]:
                self.wrong.append(f"{name}: {account['wrong']} frames twice or out of order")
            if "accepted" in account:
                there = account["taken out"] + account["in channel"] + account["lost in channel"]
                if account["accepted"] != there:
                    self.wrong.append(
                        f"{name}: accepted {account['accepted']}, read, waiting and lost {there}"
                    )
            if name in ("source", "looker-2"):
                continue
            missing = account["gaps"] + given - 1 - account["last"]
            account["missing"] = missing
            if missing > account["lost"]:
                self.wrong.append(f"{name}: {missing} frames are missing, {account['lost']} counted as lost")
        self._balance_commands()
        for name in ("dump", "record", "native"):
            self.wrong += self._read_back(name)
        for name, program in self.programs.items():
            self.wrong += [
                f"{name}: a life with {one['wrong']} wrong" for one in program.over if one.get("wrong")
            ]

    def _balance_commands(self) -> None:
        looker, commander = self.accounts["looker"], self.accounts["commander"]
        came = looker["commands"].get(str(0x200 + self.programs["commander"].lives % 256), 0)
        left = commander["aborted"] + commander["refused"] + commander["pending"]
        if commander["given"] != commander["delivered"] + left:
            self.wrong.append(
                f"commander: gave {commander['given']}, delivered {commander['delivered']} and {left} not"
            )
        looked_first = self.programs["looker"].since_s < self.programs["commander"].since_s
        if looked_first and came + looker["lost"] < commander["delivered"]:
            self.wrong.append(f"commander: {commander['delivered']} delivered, {came} came")
        told = [one.get("latest_ms", 0) for one in self.programs["looker"].over]
        self.latest_ms = max([looker["latest_ms"], *told])
        if self.latest_ms > (_AGE_S + _SLACK_S) * 1000:
            self.wrong.append(f"a command came {self.latest_ms} ms after it was given")

    def _read_back(self, name: str) -> list[str]:
        """Numbers that go back within a life of the source; `missing` has what was missed between two lives, too."""
        last, wrong, count, gaps = (-1, -1), 0, 0, 0
        for line in self.programs[name].text.read_text(errors="replace").splitlines():
            _, found, payload = line.replace("100!#", "100#").rpartition("100#")
            if not found or len(payload.split()[0]) != 12:
                continue
            data = bytes.fromhex(payload.split()[0])
            now = int.from_bytes(data[:2], "little"), int.from_bytes(data[2:], "little")
            wrong += now <= last
            gaps += now[1] - last[1] - 1 if now[0] == last[0] and now > last else 0
            last, count = max(last, now), count + 1
        self.accounts[name] = {"seen": count, "missing": gaps, "wrong": wrong}
        return [f"{name}: {wrong} frames twice or out of order"] if wrong else []

    def _given_up(self) -> int:
        """As the offer says of the commander."""
        said = self.programs["offer"].log.read_text(errors="replace")
        return sum(map(int, re.findall(r"three HW8: (\d+) frames? came after", said)))

    def table(self, trouble: Trouble, minutes: float) -> str:
        lines = [f"| {minutes:.1f} minutes | |", "|---|---|"]
        lines += [f"| {what} | {count} |" for what, count in sorted(trouble.done.items())]
        lines.append(f"| the latest command came after | {getattr(self, 'latest_ms', -1)} ms |")
        lines.append(f"| commands that were given up since they came late | {self._given_up()} |")
        lines += [
            "",
            "| program | lives | seen in the last | missing | lost | refused | ends |",
            "|---" * 7 + "|",
        ]
        for name, program in self.programs.items():
            told = self.accounts.get(name, {})
            cells = [str(told.get(key, "")) for key in ("seen", "missing", "lost", "refused")]
            reasons = "; ".join(dict.fromkeys(program.ends))[:300]
            lines.append(f"| {name} | {program.lives + 1} | {' | '.join(cells)} | {reasons} |")
        return "\n".join([*lines, "", *(self.wrong or ["every account balances"])])


def _tail(path: Path) -> str:
    with path.open("rb") as file:
        file.seek(max(0, os.fstat(file.fileno()).st_size - 4000))
        return file.read().decode(errors="replace").replace("!#", "#")


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=10.0, metavar="N", help="how long (default: 10)")
    parser.add_argument("--seed", type=int, default=0, help="of what happens when (default: 0)")
    parser.add_argument(
        "--output", type=Path, default=Path("three"), metavar="FOLDER", help="default: ./three"
    )
    arguments = parser.parse_args()
    if why := why_not():
        parser.error(f"no namespaces here: {why}")
    arguments.output.mkdir(parents=True, exist_ok=True)
    with ExitStack() as stack:
        home = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        net = stack.enter_context(machines(3, arguments.seed))
        bench = Bench(net, home, arguments.output)
        stack.callback(lambda: [program.kill() for program in bench.programs.values()])
        for way in net.spoiler.ways.values():
            way.rate = _RATE
        bench.start()
        trouble = Trouble(net, bench.programs, bench.wait, arguments.seed)
        began = time.monotonic()
        bench.wait(5)
        while time.monotonic() - began < 60 * arguments.minutes:
            at = time.monotonic() - began
            print(f"{at / 60:6.2f}  {trouble.one()}", flush=True)
        bench.settle()
        text = bench.table(trouble, arguments.minutes)
        print(text)
        (arguments.output / "three.md").write_text(text + "\n", encoding="utf-8")
        for program in bench.programs.values():
            (arguments.output / program.log.name).write_bytes(program.log.read_bytes())
    return 1 if bench.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
