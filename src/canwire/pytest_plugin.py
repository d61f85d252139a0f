"""Fixtures for tests of CAN software: `lab` and `can_bus`, in virtual time, fresh for every test.

    def test_tester_gets_an_answer(can_bus):
        ecu, tester = can_bus.node("ecu", Ecu()), can_bus.node("tester")
        tester.send(Frame(0x7DF, b"\\x02\\x01\\x0d"))
        tester.expect(0x7E8, within=0.05)

A test that fails shows, for every bus of its lab, the last frames with their senders and each node's state.
Pytest loads this module by itself wherever canwire is installed, so nothing of canwire's machinery
is imported here before a test asks for it.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from canwire import Lab, LabBus

pytest_plugins = ["canwire.pytest_hub"]  # `canwire_hub`, `canwire_faults`
_KEPT_FRAMES = 100
_LAB: pytest.StashKey[Lab] = pytest.StashKey()


@pytest.fixture
def lab(request: pytest.FixtureRequest) -> Iterator[Lab]:
    """A bench in virtual time, closed after the test; its buses remember their last frames."""
    bench = _remembering_lab()
    request.node.stash[_LAB] = bench
    with bench:
        yield bench


@pytest.fixture
def can_bus(lab: Lab) -> LabBus:
    """A CAN FD bus "can0" at 500 kbit/s and 2 Mbit/s in the lab of this test."""
    return lab.can_bus("can0", bit_rate=500_000, data_bit_rate=2_000_000)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """What was on the buses, in the report of a test that failed (in teardown they are closed already)."""
    report = yield
    bench = item.stash.get(_LAB, None)
    if bench is not None and report.failed and report.when != "teardown":
        for bus in bench.buses.values():
            report.sections.append((f"canwire: {bus.name}", describe(bus)))
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


def _remembering_lab() -> Lab:
    from canwire import Lab

    class RememberingLab(Lab):
        def can_bus(self, *arguments: Any, **options: Any) -> LabBus:
            bus = super().can_bus(*arguments, **options)
            bus.remember(_KEPT_FRAMES)
            return bus

    return RememberingLab()
