"""LIN lines in the trace: frames, headers, errors and wake-ups, beside CAN's rows and with columns of their own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

import canwire
from canwire import (
    LinControl,
    LinErrorKind,
    LinEvent,
    LinEventKind,
    LinFrame,
    LinMode,
    LinState,
    find_lines,
    record_dtype,
)
from canwire.values.lin.record import record_of_lin_frame
from canwire.web.files import static_path
from canwire.web.server import Site
from canwire.web.trace.store.lin import is_lin, lin_message, rows_of_lin
from canwire.web.trace.store.rows import GAP, LOST
from tests.cases import each
from tests.hubs import served_here
from tests.web.conftest import EMPTY, at, tab
from tests.web.trace.watching import rows_with, sender

if TYPE_CHECKING:
    import httpx2 as httpx
    from playwright.sync_api import Browser, Page

BOARD = '[[board]]\nkind = "usb-to-can-fd"\nbuses = ["can0", "can0", "lin0"]\n'
CONFIG = '[[bus]]\nname = "can0"\n[[bus]]\nname = "lin0"\ntype = "lin"\n' + 2 * BOARD
HEARD = [  # type, ID, PID, length, checksum, data
    ["LIN", "10", "50", "2", "AC E", "01 02"],
    ["LIN", "3C", "3C", "8", "00 C", "00 FF FF FF FF FF FF FF"],
    ["ERR", "12", "", "", "", "no response to this header"],
    ["ERR", "10", "", "", "", "checksum error"],
    ["WAKE", "", "", "", "", "wake-up"],
]

FRAMES = st.builds(
    LinFrame,
    st.integers(0, 63),
    st.binary(min_size=1, max_size=8),
    timestamp_ns=st.integers(0, 1 << 62),
    sent=st.booleans(),
)
HEADERS = st.builds(
    LinFrame,
    st.integers(0, 63),
    header_only=st.just(True),
    length=st.integers(0, 8),
    timestamp_ns=st.integers(0, 99),
)
EVENTS = st.builds(
    LinEvent,
    kind=st.sampled_from([LinEventKind.ERROR, LinEventKind.STATE, LinEventKind.WAKEUP, LinEventKind.SLEEP]),
    timestamp_ns=st.integers(0, 1 << 62),
    state=st.sampled_from(LinState),
    id=st.integers(-1, 63),
    transmitting=st.booleans(),
)


@given(st.lists(FRAMES | HEADERS | EVENTS, min_size=1, max_size=4))
def test_a_row_says_what_the_record_says(messages: list[LinFrame | LinEvent]) -> None:
    records = [one.to_record() if isinstance(one, LinEvent) else record_of_lin_frame(one) for one in messages]
    rows = rows_of_lin(numpy.frombuffer(b"".join(records), record_dtype()))
    assert [lin_message(row.tobytes()) for row in rows] == messages
    assert all(is_lin(row.tobytes()[12]) for row in rows)


def test_nothing_makes_no_rows() -> None:
    assert len(rows_of_lin(numpy.empty(0, record_dtype()))) == 0


def test_no_other_kind_is_a_lin_rows() -> None:
    others = {0, GAP, LOST, *map(int, canwire.EventKind)}
    assert not any(map(is_lin, others))


@pytest.fixture
def hub_address(home: Path) -> Iterator[str]:
    with served_here(home, CONFIG, time="real") as made:
        yield made


@pytest.fixture
def ends(hub: canwire.Hub) -> Iterator[list[LinControl]]:
    """lin0's master, and a slave that answers 10; both run."""
    with ExitStack() as closing:
        places = find_lines(hub, "lin0", "LIN")
        both = [closing.enter_context(hub.open_lin_control(place.board.id, place.line)) for place in places]
        first, second = both
        first.initialise(LinMode(True, 19_200, errors=True))
        second.initialise(LinMode(False, 19_200, errors=True))
        second.respond(LinFrame(0x10, b"\x01\x02"))
        for control in both:
            control.start()
        yield both


@pytest.fixture
def master(ends: list[LinControl]) -> LinControl:
    return ends[0]


@pytest.fixture
def trace(browser: Browser, site: Site) -> Iterator[Page]:
    """A tab that hears one line of each bus."""
    with tab(browser, EMPTY) as page:
        page.set_viewport_size({"width": 1500, "height": 800})
        page.goto(at(site, "trace"))
        page.locator("body[data-listening=yes]").wait_for()
        yield page


def cells(row: list[str], page: Page) -> list[str]:
    """Of the first row that has all of these texts: type, ID, PID, length, checksum, data."""
    keys = ("type", "id", "pid", "len", "sum", "data")
    found = rows_with(page, **dict(zip(keys, row, strict=True)))
    found.first.wait_for()
    return [found.first.locator(f".c-{key}").inner_text() for key in keys]


def header(master: LinControl, hub: canwire.Hub, id: int) -> None:
    """Send one, and wait until what follows it is over."""
    done = _done(master)
    master.send(LinFrame(id, header_only=True))
    while _done(master) == done:
        hub.sleep(0.005)


def _done(master: LinControl) -> int:
    status = master.status().status
    return status.frames_received + status.frames_sent + sum(status.errors)


def test_what_happens_on_a_lin_line(
    trace: Page, hub: canwire.Hub, ends: list[LinControl], client: httpx.Client
) -> None:
    page, (master, slave) = trace, ends
    header(master, hub, 0x10)
    header(master, hub, 0x12)
    hub.lin_bus("lin0").faults.checksum(0x10)
    header(master, hub, 0x10)
    master.go_to_sleep()
    while master.status().status.state != LinState.ASLEEP:
        hub.sleep(0.005)
    slave.wake_up()
    with sender(hub) as channel:
        channel.send(canwire.Frame(0x123, b"\xde\xad"))
        page.locator("#body .trace-row", has_text="DE AD").wait_for()
    assert [cells(row, page) for row in HEARD] == HEARD

    page.locator("#filter").fill("lin")
    page.locator("#filter").press("Enter")
    page.locator("#body .trace-row:not([hidden])", has_text="DE AD").wait_for(state="detached")
    lin = next(place.address for place in find_lines(hub, "lin0", "LIN"))
    log = client.get("/trace/log", params={"lines": lin, "errors": "true"}).text
    kinds = {type(canwire.parse_lin_log_line(line).content) for line in log.splitlines()}
    assert kinds == {LinFrame, LinEvent}
    assert [line.split()[2] for line in log.splitlines() if "ERROR" in line] == [
        "ERROR#SLNORE@12",
        "ERROR#CHKSUM@10",
    ]


@pytest.mark.finding("page A2")
def test_rows_open_and_columns_are_those_of_the_lines(
    trace: Page, hub: canwire.Hub, master: LinControl
) -> None:
    page = trace
    header(master, hub, 0x10)
    page.locator("#body .trace-row", has_text="01 02").click()
    page.get_by_role("heading", name="10#0102").wait_for()
    facts = page.locator("#opened").inner_text()
    for fact in ("10 (PID 50)", "AC (enhanced)"):
        assert fact in facts
    page.keyboard.press("Escape")
    header(master, hub, 0x12)
    page.locator("#body .trace-row", has_text="no response").click()
    page.get_by_role("heading", name="no response to this header").wait_for()
    page.get_by_role("columnheader", name="PID").wait_for()
    page.get_by_role("button", name="By identifier").click()
    page.locator("#body .trace-row", has_text="01 02").locator(".c-count", has_text="1").wait_for()
    for place in find_lines(hub, "lin0", "LIN"):
        page.locator("#lines").get_by_label(place.address).uncheck()
    page.get_by_role("columnheader", name="PID").wait_for(state="detached")


def test_a_lin_board_that_is_pulled_is_named_and_comes_back(trace: Page, hub: canwire.Hub) -> None:
    page = trace
    hub.unplug("HW000001")
    page.locator("#live", has_text="HW000001:2 is not plugged in").wait_for()
    for _ in range(2):  # it is said until the board is back: the page looks twice at which lines there are
        page.wait_for_event("response", lambda answer: "/trace/lines" in answer.url)
    assert "HW000001:2 is not plugged in" in page.locator("#live").inner_text()
    hub.plug("usb-to-can-fd", "HW000001", ("can0", "can0", "lin0"))
    page.locator("body[data-listening=yes]").wait_for()


def test_a_header_that_was_recorded_alone(steady: Site, asker: httpx.Client, browser: Browser) -> None:
    """Some adapters tell of one, in place of the error."""
    record = record_of_lin_frame(LinFrame(0x21, header_only=True, length=4))
    row = rows_of_lin(numpy.frombuffer(record, record_dtype()))[0].tobytes()
    assert "LIN header without a response" in asker.get("/trace/row", params={"record": row.hex()}).text
    with tab(browser, steady.address) as page:
        said = page.evaluate(
            """async ([octets, place]) => {
                const { Rows } = await import(`${place}/trace/rows.js`);
                const rows = new Rows();
                rows.set(new Uint8Array(octets).buffer, 0, 1, 0);
                const texts = ["type", "id", "pid", "dlc", "checksum", "data"];
                return texts.map((text) => rows[`${text}Text`](0));
            }""",
            [list(row + bytes(8)), static_path()],
        )
    assert said == ["HEADER", "21", "61", "4", "", ""]


@each("error", list(LinErrorKind))
def test_every_error_has_a_word(asker: httpx.Client, error: LinErrorKind) -> None:
    record = LinEvent(kind=LinEventKind.ERROR, timestamp_ns=1, error=error, id=5).to_record()
    row = rows_of_lin(numpy.frombuffer(record, record_dtype()))[0].tobytes()
    answer = asker.get("/trace/row", params={"record": row.hex()})
    assert answer.status_code == 200
    assert "trace.lin-error" not in answer.text
