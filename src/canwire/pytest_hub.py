"""Fixtures for tests of programs on shared boards: `canwire_hub` and `canwire_faults`, in virtual time.

    def test_my_reader_survives_a_bus_error(canwire_hub, canwire_faults):
        with (
            can.Bus("can0", interface="canwire", hub=canwire_hub) as ecu,
            can.Bus("can0", interface="canwire", hub=canwire_hub, error_frames=True) as reader,
        ):
            canwire_faults.inject("crc", frame_id=0x123)
            ecu.send(can.Message(0x123, is_extended_id=False))
            assert reader.recv(1).is_error_frame
            assert reader.recv(1).arbitration_id == 0x123

The report of a failed test shows the faults of its hub, how often each occurred, and every line that was set up.
pytest_plugin.py has pytest load this module, which imports the rest of canwire only when a test uses a fixture.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from canwire import CanBusFaults, Hub

_HUB: pytest.StashKey[Hub] = pytest.StashKey()


@pytest.fixture
def canwire_hub(request: pytest.FixtureRequest) -> Iterator[Hub]:
    """A private hub for this test, in virtual time, with the boards of canwire.toml, or else the default boards.

    Every interface accepts it: `can.Bus(..., hub=canwire_hub)`, `vci.initialize(canwire_hub)` for example. The test
    and the threads that it starts use the time of this hub for waits and clocks (canwire.in_time).
    """
    from canwire import connect, in_time

    with connect(time="virtual", name=request.node.name) as hub, in_time(hub):
        request.node.stash[_HUB] = hub
        yield hub
        del request.node.stash[_HUB]  # pytest keeps the tests, but no hub needs to stay in memory


@pytest.fixture
def canwire_faults(canwire_hub: Hub) -> CanBusFaults:
    """The faults of the first CAN bus of `canwire_hub`; for another bus: `canwire_hub.bus("can1").faults`."""
    from canwire import every_line

    return canwire_hub.bus(every_line(canwire_hub, "CAN")[0].info.bus).faults


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Add the faults and lines of the hub to the report of a failed test (in teardown they are gone already)."""
    report = yield
    hub = item.stash.get(_HUB, None)
    if hub is not None and not hub.lost and report.failed and report.when != "teardown":
        report.sections.append(("canwire: hub", describe(hub)))
    return report


def describe(hub: Hub) -> str:
    """The faults on its CAN buses, and the state of every CAN line that is set up."""
    from canwire import ErrorState, every_line

    places = every_line(hub, "CAN")
    lines = [
        f"{fault.bus}: {fault.text}; struck {fault.struck}, {fault.over or 'not over'}"
        for bus in dict.fromkeys(place.info.bus for place in places if place.info.bus)
        for fault in hub.bus(bus).faults.list()
    ]
    for place in places:
        status = place.status(hub)
        if status.initialised:
            state = ErrorState(status.state).name
            lines.append(f"{place.address}: {state}, TEC {status.tec}, REC {status.rec}, lost {status.lost}")
    return "\n".join(lines) or "no fault was set, no line set up"
