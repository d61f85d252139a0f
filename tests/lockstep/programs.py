"""Programs in processes of their own, on a hub in lockstep: docs/time.md's five, and what starts them."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import threading
from collections.abc import Container, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import ExitStack, contextmanager
from importlib.metadata import entry_points
from pathlib import Path

from tests import warm
from tests.cold import entry_points as written_entry_points
from tests.hubs import LONG_S, offering

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "time.md"
# a warm program has loaded python-can, which then knows of the entry points there were
START = warm.Popen if entry_points(group="can.interface", name="canwire") else subprocess.Popen
_PROGRAM = re.compile(r"<!-- program: (\w+) -->\n```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_COMMAND = re.compile(r"^\$ canwire (serve .*)$", re.MULTILINE)


def five_programs() -> dict[str, str]:
    """The page's, by name."""
    return dict(_PROGRAM.findall(PAGE.read_text(encoding="utf-8")))


def page_serves() -> list[str]:
    """The words behind `canwire` of the page's command."""
    return _COMMAND.findall(PAGE.read_text(encoding="utf-8"))[0].split()


class Bench:
    """A hub in lockstep and programs on it. `said` are the lines of the hub's stderr so far.

    `remote` names the programs that reach it over the network; `network` is its address there, once it is `offered`.
    """

    def __init__(self, home: Path, words: Sequence[str]) -> None:
        self.address = str(home / "hub.sock")
        paths = [
            written_entry_points(home),
            *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep)),
        ]
        self._environment = {
            **os.environ,
            "CANWIRE_TIMED": "1",
            "PYTHONPATH": os.pathsep.join(map(os.path.abspath, paths)),
        }
        self._closing = ExitStack()
        self._home = home
        self.said: list[str] = []
        self.network = ""
        self.remote: Container[str] = ()
        self._heard = threading.Condition()
        command = [sys.executable, "-m", "canwire", *words, "--socket", self.address]
        self._hub = warm.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=home)
        self._closing.callback(self._end_hub)
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()
        assert self._hub.stdout is not None
        assert "canwire hub on" in self._hub.stdout.readline()

    def offered(self, remote: Container[str], *words: str) -> subprocess.Popen[str]:
        """Programs of these names are on another machine from now on; what offers the hub to them."""
        self.network, process = self._closing.enter_context(offering(self.address, *words))
        self.remote = remote
        return process

    def start(self, name: str, text: str, *words: str, cold: bool = False) -> subprocess.Popen[str]:
        """A program; `cold`: a child of this process."""
        hub = self.network if name in self.remote else self.address
        process = (subprocess.Popen if cold else START)(
            [sys.executable, "-c", text, *words],
            env={**self._environment, "CANWIRE_NAME": name, "CANWIRE_HUB": hub},
            stdout=subprocess.PIPE,
            text=True,
            cwd=self._home,
        )
        assert process.stdout is not None
        self._closing.callback(process.stdout.close)
        self._closing.callback(process.wait)
        self._closing.callback(process.kill)
        return process

    def run(
        self,
        programs: Mapping[str, str],
        *words: str,
        own_words: Mapping[str, tuple[str, ...]] | None = None,
        timeout_s: float = 2 * LONG_S,
    ) -> dict[str, str]:
        """Start them all; what each has printed once it has ended, all of them well."""
        own = own_words or {}
        started = {
            name: self.start(name, text, *words, *own.get(name, ())) for name, text in programs.items()
        }
        with ThreadPoolExecutor(len(started)) as pool:
            ends = {pool.submit(one.communicate): name for name, one in started.items()}
            try:
                for end in as_completed(ends, timeout_s):
                    assert started[ends[end]].returncode == 0, (ends[end], self.said)
            finally:
                for one in started.values():
                    one.kill()
        return {name: end.result()[0] for end, name in ends.items()}

    def hears(self, what: str) -> str:
        """The first line of the hub's stderr with these words; AssertionError if it does not come."""
        with self._heard:
            assert self._heard.wait_for(lambda: any(what in line for line in self.said), LONG_S), self.said
            return next(line for line in self.said if what in line)

    def kill_hub(self) -> None:
        """As kill -9 does."""
        self._hub.kill()
        self._hub.wait(LONG_S)

    def close(self) -> None:
        self._closing.close()

    def _end_hub(self) -> None:
        self._hub.terminate()
        self._hub.wait(LONG_S)
        self._listener.join(LONG_S)
        for stream in (self._hub.stdout, self._hub.stderr):
            assert stream is not None
            stream.close()

    def _listen(self) -> None:
        assert self._hub.stderr is not None
        for line in self._hub.stderr:
            with self._heard:
                self.said.append(line.rstrip())
                self._heard.notify_all()


@contextmanager
def bench(home: Path, *words: str) -> Iterator[Bench]:
    """`canwire serve --time lockstep` with these words, in a directory of its own."""
    home.mkdir(exist_ok=True)
    made = Bench(home, words if "--time" in words else ["serve", "--time", "lockstep", *words])
    try:
        yield made
    finally:
        made.close()
