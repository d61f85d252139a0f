"""The list of the trace follows its newest row until somebody stops it, and not again before somebody wants it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

import canwire
from canwire import Frame
from canwire.web.files import static_path
from canwire.web.server import Site
from tests.hubs import LONG_S
from tests.web.trace.watching import rows_with, sender, tab_on_trace

if TYPE_CHECKING:
    from collections.abc import Iterator

    from playwright.sync_api import Browser, Page

pytestmark = pytest.mark.conforms("PG-02")

MANY = 60  # rows: more than a screen has


class Listing:
    """A trace whose rows somebody sends."""

    def __init__(self, page: Page, channel: canwire.HubChannel) -> None:
        self.page = page
        self.channel = channel
        self.newest = 0x100

    def grow(self, count: int) -> None:
        for _ in range(count):
            self.newest += 1
            self.channel.send(Frame(self.newest), timeout=LONG_S)
        self.page.locator("#shown", has_text=str(self.newest - 0x100)).wait_for()

    def row(self, number: int) -> str:
        return f"{0x100 + number:X}"

    def follows(self) -> None:
        """The newest row comes in sight when more have come: a turn of the wheel may still have to end."""
        self.grow(5)
        rows_with(self.page, id=self.row(self.newest - 0x100)).wait_for()

    def stays(self) -> None:
        """Newer rows do not move it."""
        self.grow(5)
        assert self.row(self.newest - 0x100) not in self.in_sight()

    def in_sight(self) -> list[str]:
        """Identifiers of the rows that are seen whole: one more is drawn below the window."""
        whole: list[str] = rows_with(self.page).evaluate_all("""(rows) => {
            const end = document.getElementById("body").getBoundingClientRect().bottom + 1;
            const seen = rows.filter((row) => row.getBoundingClientRect().bottom <= end);
            return seen.map((row) => row.querySelector(".c-id").textContent);
        }""")
        return whole


@pytest.fixture
def listing(browser: Browser, site: Site, hub: canwire.Hub) -> Iterator[Listing]:
    address = canwire.find_lines(hub, "can0")[0].address
    with sender(hub) as channel, tab_on_trace(browser, site, address) as page:
        made = Listing(page, channel)
        made.grow(MANY)
        yield made


def test_an_answer_is_drawn_when_it_comes(listing: Listing) -> None:
    """Else a click in between would mean another row than the one that is seen, and Pause would hold other rows."""
    counts = """async (place) => {
        const { Viewing } = await import(`${place}/trace/viewing.js`);
        const { take } = Viewing.prototype;
        window.seen = [];
        Viewing.prototype.take = function (buffer) {
            take.call(this, buffer);
            const newest = [...document.querySelectorAll("#body .trace-row:not([hidden])")].at(-1);
            window.seen.push([this.head.count, Number(newest.getAttribute("aria-rowindex")) - 1]);
        };
    }"""
    listing.page.evaluate(counts, static_path())
    listing.grow(20)
    seen = listing.page.evaluate("window.seen")
    assert seen[-1] == [MANY + 20, MANY + 20]
    assert [answered for answered, _ in seen] == [drawn for _, drawn in seen]


OWN_SCROLL = "document.getElementById('body').dispatchEvent(new Event('scroll'))"  # the browser tells of each


def test_it_stops_at_a_row_that_is_opened_or_found(listing: Listing) -> None:
    """Though it has just been scrolled to its end by itself."""
    page, row = listing.page, listing.row(MANY)
    page.locator("#body .trace-row .c-id", has_text=row).click()
    page.locator("#opened", has_text=row).wait_for()
    page.evaluate(OWN_SCROLL)
    listing.stays()
    assert row in listing.in_sight()
    page.keyboard.press("End")
    listing.follows()
    row = listing.row(listing.newest - 0x100)
    page.locator("#search").fill(row)
    page.keyboard.press("Enter")
    chosen = page.locator("#body .trace-row[aria-selected=true] .c-id")
    chosen.get_by_text(row).wait_for()
    page.evaluate(OWN_SCROLL)
    listing.stays()
    assert chosen.all_inner_texts() == [row]


def test_it_follows_again_when_somebody_comes_to_its_end(listing: Listing) -> None:
    page = listing.page
    for down in ("PageDown", "End", "wheel"):
        page.locator("#body").focus()
        page.keyboard.press("Home")
        rows_with(page, id=listing.row(1)).wait_for()
        listing.stays()
        page.locator("#body").hover()
        while listing.row(listing.newest - 0x100) not in listing.in_sight():
            if down == "wheel":
                page.mouse.wheel(0, 3000)
            else:
                page.keyboard.press(down)
        listing.follows()
        page.keyboard.press("ArrowUp")
        listing.stays()
