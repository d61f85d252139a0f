"""Runs tests on a copy of the tree in which one mutant stands."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from tests.mutants.drawing import Mutant
from tests.mutants.selection import stages

CPU_S = {
    True: 60.0,
    False: 120.0,
}  # of the tests' process for a mutant, compiled and not: the same on a busy machine
WALL_S = 600.0  # and whatever they wait for
ONE_TEST_S = 120  # a test that hangs on a mutant fails after this
_MARK = "CANWIRE_MUTANTS"  # in the environment of every process that a run started, however it went on
_FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+?\.py(?:::.*?)?)(?: - .*)?$", re.MULTILINE)


class Verdict(NamedTuple):
    """`by` is the test that failed, or what else ended the run."""

    status: str  # "killed" or "survived"
    by: str
    seconds: float


class Outcome(NamedTuple):
    """How a run of some tests ended: "passed", "failed" (by a test) or "limit"; the processor's seconds."""

    end: str
    by: str
    seconds: float


class Tree:
    """A copy of everything that git knows or would take, with the compiled files or without them."""

    def __init__(self, root: Path, home: Path, compiled: bool) -> None:
        self.root, self._home = home / ("compiled" if compiled else "pure"), home
        listed = subprocess.run(
            ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=root,
            capture_output=True,
            text=True,
            check=True,
        )
        names = [name for name in listed.stdout.split("\0") if name and (root / name).is_file()]
        names += [
            str(path.relative_to(root))
            for path in root.glob("src/**/*.so")
            if compiled or "_shim" in path.name
        ]
        for name in names:
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(root / name, self.root / name)

    def write(self, file: str, source: str) -> None:
        """Another text for a file; what Python keeps of its former text goes, whose size and second may be the same."""
        path = self.root / file
        path.write_text(source, "utf-8")
        for kept in path.parent.glob(f"__pycache__/{path.stem}.*.pyc"):
            kept.unlink()

    @contextmanager
    def changed(self, file: str, change: Callable[[str], str]) -> Iterator[None]:
        """The file has its changed text meanwhile."""
        source = (self.root / file).read_text("utf-8")
        self.write(file, change(source))
        try:
            yield
        finally:
            self.write(file, source)

    def run(
        self, tests: Sequence[str], without: Sequence[str], cpu_s: float, to_the_end: bool = False
    ) -> Outcome:
        """These tests, up to the first that fails; or all, and the outcome's `by` has a line for each that fails."""
        command = f"{sys.executable} -m pytest -q --no-header --tb=no -rfE -p no:cacheprovider".split()
        for plugin in ("xdist", "xdist.looponfail", "anyio", "platformdirs"):
            command += ["-p", f"no:{plugin}"]  # it starts quicker without
        command += ["-o", f"timeout={ONE_TEST_S}", *([] if to_the_end else ["-x"])]
        command += [*(f"--deselect={test}" for test in without), *tests]
        with (self._home / "output").open("w+") as output:
            process = subprocess.Popen(
                command, cwd=self.root, env=self._environment(), start_new_session=True,
                stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
            )  # fmt: skip
            try:
                spent_s = _waited(process, cpu_s)
            finally:
                end_all(str(self._home))
                process.wait()
            output.seek(0)
            found = _FAILED.findall(output.read())
        if process.returncode == -signal.SIGKILL:
            return Outcome("limit", "", spent_s)
        if process.returncode in (0, 5):
            return Outcome("passed", "", spent_s)
        return Outcome("failed", "\n".join(found) or f"exit status {process.returncode}", spent_s)

    def _environment(self) -> dict[str, str]:
        places = {name: self._home / folder for name, folder in (("TMPDIR", "t"), ("XDG_RUNTIME_DIR", "r"))}
        for place in places.values():
            shutil.rmtree(place, ignore_errors=True)
            place.mkdir(mode=0o700)
        unset = ("CANWIRE_EXPECT", "CANWIRE_HUB")
        kept = {name: value for name, value in os.environ.items() if name not in unset}
        more = {name: str(place) for name, place in places.items()}
        return kept | more | {"PYTHONPATH": str(self.root / "src"), "CI": "true", _MARK: str(self._home)}


def _waited(process: subprocess.Popen[bytes], cpu_s: float) -> float:
    """Until it ends or has used up what it may; the processor's seconds that it and its ended children took."""
    began, spent_s = time.monotonic(), 0.0
    while spent_s < cpu_s and time.monotonic() - began < WALL_S:
        numbers = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
        spent_s = sum(map(int, numbers[11:15])) / os.sysconf("SC_CLK_TCK")
        try:
            process.wait(0.25)
        except subprocess.TimeoutExpired:
            continue
        break
    return spent_s


class Judge:
    """Judges mutants one after the other; what it learns about the unchanged source it asks once."""

    def __init__(self, root: Path, home: Path) -> None:
        self._trees = {compiled: Tree(root, home, compiled) for compiled in (True, False)}
        self._core = core_files(root)
        self._kills: Counter[tuple[bool, str]] = Counter()
        self._failing: dict[bool, list[str]] = {True: [], False: []}
        self._within: dict[tuple[bool, frozenset[str]], bool] = {}

    def verdict(self, mutant: Mutant) -> Verdict:
        """Killed by the first test that fails twice, but passes on the unchanged source."""
        began = time.monotonic()
        compiled = self._compiled(mutant)
        status, by = "survived", ""
        waiting = stages(self._trees[compiled].root, mutant)
        every = frozenset(file for stage in waiting for file in stage)
        by_chance: list[str] = []
        left_s = CPU_S[compiled]
        while waiting and status == "survived":
            end, by, spent_s = self._run(mutant, waiting[0], by_chance, left_s)
            left_s -= spent_s
            if end == "limit" or left_s <= 0:
                status, by = ("killed" if self._quick(compiled, every) else "survived"), "the time limit"
                break
            if end == "passed":
                waiting.pop(0)
            elif "::" in by and self._run(mutant, [by], [], CPU_S[compiled]).end == "passed":
                by_chance.append(by)
            elif self._believed(compiled, by):
                status = "killed"
        return Verdict(status, by, round(time.monotonic() - began, 1))

    def _run(self, mutant: Mutant, tests: Sequence[str], without: Sequence[str], cpu_s: float) -> Outcome:
        """These tests on the source with this mutant."""
        compiled = self._compiled(mutant)
        tree = self._trees[compiled]
        with tree.changed(mutant.file, mutant.applied):
            return tree.run(tests, [*self._failing[compiled], *without], cpu_s)

    def failing_anyway(self, rows: Sequence[tuple[Mutant, str]]) -> list[Mutant]:
        """Those of these mutants and their killers whose killer fails on the unchanged source, too."""
        for compiled, tree in self._trees.items():
            killers = {by for mutant, by in rows if self._compiled(mutant) == compiled and "::" in by}
            if killers:
                ends = tree.run(sorted(killers), [], CPU_S[compiled] * len(killers), to_the_end=True)
                self._failing[compiled] += ends.by.split("\n") if ends.end == "failed" else []
        return [mutant for mutant, by in rows if by in self._failing[self._compiled(mutant)]]

    def _believed(self, compiled: bool, test: str) -> bool:
        """A test that fails twice has to show that it passes on the unchanged source; the others show it in the end."""
        self._kills[compiled, test] += 1
        if test in self._failing[compiled]:
            return True  # it cannot be left out, as it seems
        if self._kills[compiled, test] == 2 and "::" in test:
            if self._trees[compiled].run([test], [], CPU_S[compiled]).end == "passed":
                return True
            self._failing[compiled].append(test)
            return False
        return True

    def _compiled(self, mutant: Mutant) -> bool:
        return mutant.file not in self._core

    def _quick(self, compiled: bool, files: frozenset[str]) -> bool:
        """Do these tests of the unchanged source take less than half of the limit?"""
        if (compiled, files) not in self._within:
            outcome = self._trees[compiled].run(sorted(files), self._failing[compiled], CPU_S[compiled] / 2)
            self._within[compiled, files] = outcome.end == "passed"
        return self._within[compiled, files]


def end_all(home: str) -> None:
    """Ends every process whose environment names this scratch folder: hubs and programs that tests left behind."""
    mark = f"{_MARK}={home}".encode()
    for place in Path("/proc").glob("[0-9]*"):
        try:
            if mark in (place / "environ").read_bytes().split(b"\0"):
                os.kill(int(place.name), signal.SIGKILL)
        except OSError:
            continue  # it has ended meanwhile, or belongs to somebody else


def core_files(root: Path) -> set[str]:
    """The source files that are compiled, as `src/canwire/ring.py`."""
    text = (root / "setup.py").read_text("utf-8")
    names = re.findall(r'^    "(canwire\.[\w.]+)": \d', text, re.MULTILINE)
    return {f"src/{name.replace('.', '/')}.py" for name in names}
