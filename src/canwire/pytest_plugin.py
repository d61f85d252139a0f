"""Fixtures for tests of CAN and LIN software, in virtual time, fresh for every test: `lab`, `can_bus`, `lin_bus`.

    def test_tester_gets_an_answer(can_bus):
        ecu, tester = can_bus.node("ecu", Ecu()), can_bus.node("tester")
        tester.send(Frame(0x7DF, b"\\x02\\x01\\x0d"))
        tester.expect(0x7E8, within=0.05)

Their full names are `canwire_lab`, `canwire_bus` and `canwire_lin_bus`. To use the short names for other fixtures:

    [tool.pytest.ini_options]
    canwire_short_fixtures = false

`canwire_lockstep({"ecu": TEXT, "tester": TEXT})` runs programs in separate processes that share one virtual time,
with the same result in every run (docs/time.md).

A test that fails shows, for every bus of its lab, the last frames with their senders and each node's state.
Pytest loads this module wherever canwire is installed, so the module imports the rest of canwire only
when a test uses a fixture.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping
from functools import cache
from typing import IO, TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from pathlib import Path

    from canwire import Lab, LabBus, LabLinBus

pytest_plugins = ["canwire.pytest_hub"]  # `canwire_hub`, `canwire_faults`
_KEPT_FRAMES = 100
_LAB: pytest.StashKey[Lab] = pytest.StashKey()


_SHORT = "canwire_short_fixtures"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add one ini option."""
    parser.addini(
        _SHORT, "offer lab, can_bus and lin_bus for canwire_lab, canwire_bus, canwire_lin_bus", "bool", True
    )


def pytest_configure(config: pytest.Config) -> None:
    """Offer the short names, unless the project uses them for other fixtures."""
    if config.getini(_SHORT):
        config.pluginmanager.register(_ShortNames(), "canwire-short-fixtures")


@pytest.fixture
def canwire_lab(request: pytest.FixtureRequest) -> Iterator[Lab]:
    """A lab in virtual time, closed after the test; its buses keep their last frames."""
    request.node.stash[_LAB] = bench = _lab_type()()
    with bench:
        yield bench
    del request.node.stash[_LAB]  # pytest keeps the tests, but no lab needs to stay in memory


@pytest.fixture
def canwire_lockstep(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., dict[str, str]]:
    """Run programs in lockstep on a new hub for each call; returns the output of each program by name.

    `canwire_lockstep(programs, timeout=60)`: `programs` maps names to the text of Python programs, in the order of
    their turns. The hub has the boards of canwire.toml, or the default boards. Raises AssertionError, with the errors
    printed by the program and by the hub, if a program fails or does not end within `timeout` seconds of real time.
    """

    def run(programs: Mapping[str, str], timeout: float = 60.0) -> dict[str, str]:
        return _run_in_lockstep(tmp_path_factory.mktemp("lockstep"), programs, timeout)

    return run


def _run_in_lockstep(home: Path, programs: Mapping[str, str], timeout_s: float) -> dict[str, str]:
    import concurrent.futures
    import os
    import subprocess
    import sys

    address = str(home / "hub.sock")
    started: dict[str, subprocess.Popen[bytes]] = {}
    variables = {**os.environ, "CANWIRE_HUB": address, "CANWIRE_TIMED": "1"}
    serve = [
        "-m",
        "canwire",
        "serve",
        "--time",
        "lockstep",
        "--programs",
        ",".join(programs),
        "--socket",
        address,
    ]

    def start(name: str, words: list[str], output: int | IO[bytes]) -> subprocess.Popen[bytes]:
        with (home / f"{name}.err").open("wb") as errors:
            named = {**variables, "CANWIRE_NAME": name}
            started[name] = subprocess.Popen(
                [sys.executable, *words], stdout=output, stderr=errors, env=named
            )
        return started[name]

    def said(name: str, what: str) -> str:
        return (home / f"{name}.{what}").read_text(errors="replace")

    try:
        with start("the hub", serve, subprocess.PIPE).stdout as introduction:  # type: ignore[union-attr]
            assert introduction.readline(), said("the hub", "err")
        for name, text in programs.items():
            with (home / f"{name}.out").open("wb") as output:
                start(name, ["-c", text], output)
        with concurrent.futures.ThreadPoolExecutor(len(programs)) as pool:
            ends = {pool.submit(started[name].wait, timeout_s): name for name in programs}
            for end in concurrent.futures.as_completed(ends):
                name = ends[end]
                if end.exception() is not None or end.result():
                    for one in started.values():
                        one.kill()
                    raise AssertionError(
                        f"{name} failed:\n{said(name, 'err')}\nthe hub:\n{said('the hub', 'err')}"
                    )
    finally:
        for one in started.values():
            one.terminate()
            one.wait()
    return {name: said(name, "out") for name in programs}


@pytest.fixture
def canwire_bus(canwire_lab: Lab) -> LabBus:
    """A CAN FD bus "can0" at 500 kbit/s and 2 Mbit/s in the lab of this test."""
    return canwire_lab.can_bus("can0", bit_rate=500_000, data_bit_rate=2_000_000)


@pytest.fixture
def canwire_lin_bus(canwire_lab: Lab) -> LabLinBus:
    """A LIN bus "lin0" at 19,200 bit/s in the lab of this test."""
    return canwire_lab.lin_bus("lin0")


class _ShortNames:
    """The same fixtures under short names."""

    @pytest.fixture
    def lab(self, canwire_lab: Lab) -> Lab:
        """canwire_lab."""
        return canwire_lab

    @pytest.fixture
    def can_bus(self, canwire_bus: LabBus) -> LabBus:
        """canwire_bus."""
        return canwire_bus

    @pytest.fixture
    def lin_bus(self, canwire_lin_bus: LabLinBus) -> LabLinBus:
        """canwire_lin_bus."""
        return canwire_lin_bus


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Add the frames on the buses to the report of a failed test (in teardown the buses are closed already)."""
    report = yield
    bench = item.stash.get(_LAB, None)
    if bench is not None and report.failed and report.when != "teardown":
        for bus in bench.buses.values():
            report.sections.append((f"canwire: {bus.name}", describe(bus)))
        for lin_bus in bench.lin_buses.values():
            report.sections.append((f"canwire: {lin_bus.name}", describe_lin(lin_bus)))
    return report


def describe(bus: LabBus) -> str:
    """The last frames of a bus as candump shows them, with their senders, and the state of its nodes."""
    from canwire import LogLine, format_candump_line

    lines = []
    for sender, frame in bus.recent():
        line = LogLine(frame.timestamp_ns, bus.name, frame)
        lines.append(f"{format_candump_line(line, timestamp=True)}  ; {sender}")
    if not lines:
        lines.append("no frame got through")
    for node in bus.nodes.values():
        queues = f"lost {node.lost}, {node.waiting} waiting, {node.pending} to send"
        lines.append(f"{node.name}: {node.state.name}, TEC {node.tec}, REC {node.rec}, {queues}")
    return "\n".join(lines)


def describe_lin(bus: LabLinBus) -> str:
    """The last frames of a LIN bus, each followed by the node that answered, and the state of its nodes."""
    from canwire import LinLogLine, format_lin_log_line

    lines = []
    for sender, frame in bus.recent():
        lines.append(f"{format_lin_log_line(LinLogLine(frame.timestamp_ns, bus.name, frame))}  ; {sender}")
    if not lines:
        lines.append("no frame got through")
    for node in bus.nodes.values():
        lines.append(
            f"{node.name}: {node.state.name}, lost {node.lost}, {node.waiting} waiting, {node.pending} to send"
        )
    return "\n".join(lines)


@cache
def _lab_type() -> type[Lab]:
    from canwire import Lab

    class RememberingLab(Lab):
        def can_bus(self, *arguments: Any, **options: Any) -> LabBus:
            bus = super().can_bus(*arguments, **options)
            bus.remember(_KEPT_FRAMES)
            return bus

        def lin_bus(self, *arguments: Any, **options: Any) -> LabLinBus:
            bus = super().lin_bus(*arguments, **options)
            bus.remember(_KEPT_FRAMES)
            return bus

    return RememberingLab
