"""Samples of counters, and faults put on a bus from the page."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

import canwire
from canwire import BadValue, WantedMode
from canwire.web.lines import Line, can_lines
from canwire.web.statistics.faults import Faults
from canwire.web.statistics.sampler import KEPT, Sampler
from tests.cases import each
from tests.web.conftest import EMPTY, at, counts, served_site, somebody, tab

if TYPE_CHECKING:
    import httpx2 as httpx
    from playwright.sync_api import Browser, Page

    from canwire.web.server import Site

pytestmark = pytest.mark.conforms("PG-06")


@pytest.fixture
def line(hub: canwire.Hub) -> Line:
    return can_lines(hub)[0]


@pytest.fixture
def sampler() -> Sampler:
    """One that looks only when it is told to."""

    def away() -> canwire.Hub:
        raise canwire.HubLost("away")

    made = Sampler(away)
    made.close()
    return made


def after(line: Line, seconds: float, **counters: int) -> Line:
    assert line.can is not None
    status = replace(line.can, time_ns=line.can.time_ns + round(seconds * 1e9), **counters)
    return line._replace(can=status)


def test_rates_are_counted_a_second(sampler: Sampler, line: Line) -> None:
    sampler.look([line])
    sampler.look([after(line, 0.5, frames_sent=100, errors=3, tec=8)])
    (sample,) = sampler.samples(line.place.address, 0)
    assert (sample.sent, sample.received, sample.errors, sample.tec) == (200.0, 0.0, 6.0, 8)


def test_counters_that_began_anew_give_no_negative_rate(sampler: Sampler, line: Line) -> None:
    sampler.look([after(line, 0, frames_sent=1000)])
    sampler.look([after(line, 1, frames_sent=10)])
    assert sampler.samples(line.place.address, 0)[-1].sent == 10.0


def test_a_hub_that_was_started_anew_gives_no_sample_of_two_times(sampler: Sampler, line: Line) -> None:
    sampler.look([after(line, 100)])
    sampler.look([])
    sampler.look([after(line, 1)])
    assert sampler.samples(line.place.address, 0) == []


def test_only_ten_minutes_are_kept_and_only_new_samples_are_given(sampler: Sampler, line: Line) -> None:
    for number in range(KEPT + 50):
        sampler.look([after(line, number)])
    kept = sampler.samples(line.place.address, 0)
    assert len(kept) == KEPT
    assert sampler.samples(line.place.address, kept[-2].number) == kept[-1:]


@each("after", ["-1", "x", "", "9" * 13])
def test_samples_after_nonsense_are_refused(asker: httpx.Client, after: str) -> None:
    assert asker.get("/statistics/samples", params={"after": after}).status_code == 422


@contextmanager
def low_speed(hub: canwire.Hub) -> Iterator[canwire.Control]:
    """A line whose transceiver tells of a fault of the wires."""
    place = next(place for place in canwire.every_line(hub, "CAN") if place.board.kind == "usb-to-can")
    mode = WantedMode(125_000).mode(place.info.capabilities)
    with canwire.start_line(hub, place, replace(mode, low_speed=True)) as control:
        yield control


def test_a_short_is_put_on_the_bus_and_taken_back(client: httpx.Client, hub: canwire.Hub) -> None:
    with low_speed(hub) as control:
        answer = client.post("/statistics/fault", data={"bus": "can0", "kind": "short"})
        assert answer.status_code == 200, answer.text
        assert control.status().coupling_fault
        assert "can0" in client.get("/statistics/faults").text
        assert client.post("/statistics/cancel", data={"number": "1"}).status_code == 200
        assert not control.status().coupling_fault
        assert client.post("/statistics/cancel", data={"number": "1"}).status_code == 409


@each(("bus", "kind", "status"), [("can9", "short", 409), ("can0", "rain", 422), ("", "short", 422)])
def test_a_fault_that_cannot_be_is_refused(asker: httpx.Client, bus: str, kind: str, status: int) -> None:
    assert asker.post("/statistics/fault", data={"bus": bus, "kind": kind}).status_code == status


def test_what_was_set_here_ends_with_the_server(hub_address: str, hub: canwire.Hub) -> None:
    with low_speed(hub) as control:
        with served_site(hub_address) as site, somebody(site) as client:
            client.post("/statistics/fault", data={"bus": "can0", "kind": "short"})
            assert control.status().coupling_fault
        assert not control.status().coupling_fault


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"kind": "flip", "bit": "20", "id": "100", "times": "3"}, "flip bit 20 of 100, 3 times"),
        ({"kind": "inject", "error": "crc", "times": "1"}, "crc"),
        ({"kind": "noise", "noise": "0.001"}, "noise, 0.001 of all bits"),
        ({"kind": "disconnect", "line": "HW000001:0"}, "disconnect HW000001:0"),
        ({"kind": "short"}, "short circuit"),
    ],
)
def test_every_fault_of_the_menu_is_on_the_bus_until_it_is_taken_back(
    client: httpx.Client, hub: canwire.Hub, fields: dict[str, str], text: str
) -> None:
    assert client.post("/statistics/fault", data={"bus": "can0", **fields}).status_code == 200
    assert len(hub.bus("can0").faults.list()) == 1
    assert text in client.get("/statistics/faults").text
    assert client.post("/statistics/cancel", data={"number": "1"}).status_code == 200
    assert [one for one in hub.bus("can0").faults.list() if not one.over] == []


@each(
    ("fields", "field"),
    [
        ({"kind": "flip", "bit": "x", "times": "1"}, "bit"),
        ({"kind": "flip", "bit": "1", "times": "0"}, "times"),
        ({"kind": "inject", "error": "rain", "times": "1"}, "error"),
        ({"kind": "noise", "noise": "2"}, "noise"),
        ({"kind": "wrong-rate", "line": "HW000001:0", "rate": "1"}, "rate"),
    ],
)
def test_a_fault_s_wrong_value_is_told_at_its_field(
    asker: httpx.Client, fields: dict[str, str], field: str
) -> None:
    answer = asker.post("/statistics/fault", data={"bus": "can0", **fields})
    assert answer.status_code == 422
    assert set(answer.json()["faults"]) == {field}


def test_a_fault_of_nobody_cannot_be_taken_back() -> None:
    with pytest.raises(BadValue, match="fault 1"):
        Faults().cancel(1)


@pytest.fixture
def view() -> str:
    return "statistics"


def test_plots_and_table_in_the_browser(page: Page, hub: canwire.Hub) -> None:
    place = canwire.find_lines(hub, "can0")[0]
    with canwire.start_line(hub, place, WantedMode(500_000).mode(place.info.capabilities)):
        page.get_by_role("img", name="Bus load: 0.0 % now").wait_for()
        counts(page.locator(".uplot"), 4)
        page.get_by_role("row", name=place.address).get_by_text("error active").wait_for()
        page.locator("select[name=kind]").select_option("short")
        page.get_by_role("button", name="Set").click()
        page.get_by_text("Set on can0: short circuit.").wait_for()
        page.get_by_role("button", name="Take back").click()
        page.get_by_text("No fault is set.").wait_for()


@pytest.mark.finding("page A5")
@pytest.mark.parametrize("time_s", [1, 7.000000001])
def test_a_single_sample_is_plotted_at_any_time(browser: Browser, steady: Site, time_s: float) -> None:
    with tab(browser, EMPTY) as page:
        sample = {"columns": [[1], [time_s], [25.0], [0], [0], [0], [0], [0], [0]]}
        page.route("**/statistics/samples?*", lambda route: route.fulfill(json=sample))
        page.goto(at(steady, "statistics"))
        page.get_by_role("img", name="Bus load: 25.0 % now").wait_for()
        page.locator(".u-axis").first.wait_for()
        legend = page.locator("#plot-load .u-legend")
        legend.get_by_text("25.0").wait_for()  # the newest value, where there is no cursor
        assert f"{time_s:g} s" in legend.inner_text()
