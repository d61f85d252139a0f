"""Curves of signals: every peak of many points, and by a click in the browser."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

import canwire
from canwire import Frame
from canwire.web.trace import plotting
from canwire.web.trace.plotting import thinned
from tests.effort import examples
from tests.hubs import LONG_S
from tests.web.conftest import caller, served_site
from tests.web.trace.test_filtering import DBC
from tests.web.trace.watching import rows_with, sender, tab_on_trace

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.sync_api import Browser

pytestmark = pytest.mark.conforms("PG-05")


@examples(40)
@given(st.lists(st.integers(-1000, 1000), max_size=200))
def test_a_thinned_curve_has_its_ends_in_order_and_its_peaks(values: list[int]) -> None:
    most, plotting.MOST_POINTS = plotting.MOST_POINTS, 20
    try:
        times, kept = thinned(numpy.arange(len(values), dtype=float), numpy.array(values, float))
    finally:
        plotting.MOST_POINTS = most
    assert len(kept) <= 20 + 20
    assert times == sorted(times)
    assert [values[int(time)] for time in times] == kept
    if values:
        assert (min(kept), max(kept)) == (min(values), max(values))


@pytest.mark.finding("page B2")
@pytest.mark.conforms("PG-02", "PG-12")
def test_signals_in_rows_are_plotted_by_a_click_and_rows_marked_and_filtered(
    browser: Browser, hub_address: str, hub: canwire.Hub, tmp_path: Path
) -> None:
    path = tmp_path / "car.dbc"
    path.write_text(DBC)
    address = canwire.find_lines(hub, "can0")[0].address
    with (
        served_site(hub_address, [str(path)]) as site,
        sender(hub) as channel,
        tab_on_trace(browser, site, address) as page,
    ):
        for speed in (4000, 6000, 8000):
            channel.send(Frame(0x100, speed.to_bytes(2, "little") + bytes(6)), timeout=LONG_S)
        channel.send(Frame(0x555), timeout=LONG_S)
        page.get_by_role("button", name="By identifier").click()
        page.get_by_role("button", name="Speed 2000 rpm").click()
        page.locator("#plot-keys", has_text="2000.00").wait_for()
        assert page.locator("#plot canvas").count() == 1
        channel.send(Frame(0x100, (400).to_bytes(2, "little") + bytes(6)), timeout=LONG_S)
        page.locator("#plot-keys", has_text="100.00").wait_for()
        row = page.locator("#body .trace-row:not([hidden])", has_text="Engine")
        for speed in itertools.cycle((800, 400)):  # a byte is marked for a second after it has changed
            if row.locator("b").count():
                break
            channel.send(Frame(0x100, speed.to_bytes(2, "little") + bytes(6)), timeout=LONG_S)
        page.get_by_role("button", name="Remove Speed").click()
        page.locator("#plots").wait_for(state="hidden")

        page.get_by_role("button", name="By time").click()
        page.locator("#filter").press_sequentially("Speed > 1200")
        page.locator("#shown", has_text="2").wait_for()
        page.locator("#filter").press("Escape")
        page.locator('#grid[data-filter=""]').wait_for()
        rows_with(page, id="555").click(button="right")
        page.get_by_role("menuitem", name="Mark").click()
        page.locator("#body .trace-row.marked .c-id", has_text="555").wait_for()
        page.locator("#body .trace-row:not([hidden])", has_text="Engine").first.click(button="right")
        page.get_by_role("menuitem", name="Not this").click()
        page.locator('#grid[data-filter="!id:100"]').wait_for()
        page.locator("#body").focus()
        page.keyboard.press("n")
        page.locator("#body .trace-row[aria-selected=true] .c-id", has_text="555").wait_for()
        page.reload()
        page.locator("#body .trace-row.marked .c-id", has_text="555").wait_for()  # kept as long as the tab


def test_what_is_no_signal_is_refused(hub_address: str) -> None:
    with served_site(hub_address) as site, caller(site) as client:
        assert client.get("/trace/plot", params={"line": "x", "id": "100", "signal": "S"}).status_code == 422
        answer = client.get("/trace/plot", params={"line": "0", "id": "100", "signal": "S"})
        assert answer.json() == {"t": [], "v": [], "next": 0}
