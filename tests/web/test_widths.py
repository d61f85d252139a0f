"""The trace at the widths that screens have: nothing is cut off, and enough rows are in sight beside what is opened."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

import pytest

import canwire
from canwire import Frame
from tests.hubs import LONG_S
from tests.web.conftest import EMPTY, at, tab
from tests.web.trace.watching import sender, tab_on_trace

if TYPE_CHECKING:
    from collections.abc import Iterator

    from playwright.sync_api import Browser, Page, ViewportSize

    from canwire.web.server import Site

pytestmark = [pytest.mark.conforms("PG-13"), pytest.mark.finding("page B7")]

SCREENS: tuple[ViewportSize, ...] = (
    {"width": 1920, "height": 1080},
    {"width": 1366, "height": 768},
    {"width": 1280, "height": 720},
    {"width": 390, "height": 844},
)
LOOK = """() => {
  const rows = [...document.querySelectorAll("#body .trace-row:not([hidden])")];
  const cells = rows.map((row) => row.querySelector(".c-data"));
  const edge = (cell) => {
    const range = document.createRange();
    range.selectNodeContents(cell);
    return range.getBoundingClientRect().right;
  };
  const body = document.getElementById("body").getBoundingClientRect();
  return {
    cut: cells.filter((cell) => cell.scrollWidth > cell.clientWidth).map((cell) => cell.textContent),
    right: Math.max(...cells.map(edge)),
    list: document.querySelector(".trace-wide").getBoundingClientRect().right,
    rows: Math.floor(body.height / 22),
    top: body.top,
  };
}"""


class Seen(NamedTuple):
    """A screen: texts of cells that are cut off, where data and list end, rows that fit, where they begin."""

    cut: list[str]
    right: float
    list: float
    rows: int
    top: float


def seen(page: Page, screen: ViewportSize) -> Seen:
    page.set_viewport_size(screen)
    page.locator("#body .trace-row:not([hidden])", has_text="11 22 33").first.wait_for()
    told = page.evaluate(LOOK)
    return Seen(told["cut"], told["right"], told["list"], told["rows"], told["top"])


@pytest.fixture
def trace(browser: Browser, site: Site, hub: canwire.Hub) -> Iterator[Page]:
    """Frames of eight bytes, the last of them with 29 bits of identifier."""
    address = canwire.find_lines(hub, "can0")[0].address
    with sender(hub) as channel, tab_on_trace(browser, site, address) as page:
        for number in range(40):
            data = bytes.fromhex("1122334455667788")
            channel.send(Frame(0x100 + number, data, extended=number == 39), timeout=LONG_S)
        page.locator("#shown", has_text="40").wait_for()
        yield page


@pytest.mark.finding("page 9", "page A3", "page A4")
def test_data_are_whole_and_rows_enough_at_every_width(trace: Page) -> None:
    for screen in SCREENS:
        plain = seen(trace, screen)
        assert plain.cut == [], screen
        assert plain.top < screen["height"] / 2, screen  # also where late rows are counted in another line
    trace.locator("#body .trace-row:not([hidden])").first.click()
    trace.locator(".wire svg").wait_for()
    for screen in SCREENS:
        opened = seen(trace, screen)
        assert opened.cut == [], screen
        if screen["width"] > 1000:
            assert opened.rows >= 15, screen
            assert opened.right <= opened.list, screen
    trace.locator("#close-details").click()
    trace.get_by_role("button", name="By identifier").click()
    trace.locator('#body .trace-row[aria-rowindex="2"] .c-id', has_text="100").wait_for()  # the first one
    for screen in SCREENS:
        by_identifier = seen(trace, screen)
        assert by_identifier.cut == [], screen
        assert by_identifier.right <= by_identifier.list, screen


@pytest.mark.finding("page A7")
def test_the_buttons_of_all_rows_line_up(browser: Browser, steady: Site) -> None:
    with tab(browser, EMPTY) as page:
        rows = ({"format": "classic", "data": "11", "cycle": "10"}, {"format": "remote", "comment": "a text"})
        page.goto(at(steady, "send"))
        for row in rows:
            page.request.post(f"{steady.url}send/put", form={"line": "HW000001:0", "id": "1", **row})
        buttons = page.locator("#list .doings")
        buttons.nth(1).wait_for()
        boxes = buttons.evaluate_all(
            "all => all.map(one => [...one.querySelectorAll('button')].map(button => button.getBoundingClientRect()))"
            ".map(boxes => boxes.map(box => Math.round(box.right)).at(-1))"
        )
        for number in re.findall(r'data-row="(\d+)"', page.request.get(f"{steady.url}send/list").text()):
            page.request.post(f"{steady.url}send/remove", form={"number": number})
    assert len(set(boxes)) == 1
