"""The trace: what the server sends, and what the page makes of it."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from websockets.exceptions import ConnectionClosedError
from websockets.sync.client import connect

import canwire
from canwire import ChannelMode, Frame, WantedMode
from canwire.web.server import Site
from canwire.web.trace.store.rows import rows_of
from tests.cases import each
from tests.hubs import LONG_S, served_here
from tests.web.conftest import at, holds, served_site, tab
from tests.web.trace.watching import Watching, rows_with, sender, tab_on_trace, watching

if TYPE_CHECKING:
    import httpx2 as httpx
    from playwright.sync_api import Browser, Locator, Page


@pytest.mark.conforms("PG-01", "PG-02")
def test_two_viewers_see_every_frame_once(site: Site, hub: canwire.Hub) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    frames = [Frame(number, bytes([number & 0xFF])) for number in range(200)]
    with watching(site, [address]) as one, watching(site, [address]) as other, sender(hub) as channel:
        for frame in frames:
            channel.send(frame, timeout=LONG_S)
        for viewer in (one, other):
            viewer.until(lambda one: len(one.frames) >= len(frames))
            assert viewer.frames == frames
            assert (viewer.head["lost"], viewer.head["late"]) == (0, 0)


@pytest.mark.finding("page B1")
def test_a_late_viewer_has_the_same_rows_from_the_beginning(site: Site, hub: canwire.Hub) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    with watching(site, [address]) as first, sender(hub) as channel:
        for number in range(20):
            channel.send(Frame(number), timeout=LONG_S)
        first.until(lambda one: len(one.frames) == 20)
        with watching(site, [address]) as late:
            late.until(lambda one: len(one.frames) == 20)
            assert late.rows.tobytes() == first.rows.tobytes()


@pytest.mark.finding("page 1")
@pytest.mark.conforms("N-53")
def test_a_viewer_that_was_cut_off_has_the_rows_of_one_that_was_not(site: Site, hub: canwire.Hub) -> None:
    """And frames that came while nobody watched are there, too."""
    address = canwire.find_lines(hub, "can0")[0].address
    with watching(site, [address]) as steady, sender(hub) as channel:
        with watching(site, [address]) as cut:
            channel.send(Frame(1), timeout=LONG_S)
            cut.until(lambda one: len(one.frames) == 1)
        for number in range(2, 500):
            channel.send(Frame(number), timeout=LONG_S)
        steady.until(lambda one: len(one.frames) == 499)
    with sender(hub) as channel:
        channel.send(Frame(500), timeout=LONG_S)
        with watching(site, [address]) as back:
            back.until(lambda one: len(one.frames) == 500)
    assert [frame.id for frame in back.frames] == list(range(1, 501))


@pytest.mark.finding("page 3")
@pytest.mark.conforms("N-53")
def test_rows_of_two_buses_are_in_the_order_of_their_stamps(home: Path) -> None:
    buses = '[[bus]]\nname = "can0"\n[[bus]]\nname = "can1"\n'
    boards = 2 * '[[board]]\nkind = "usb-to-can-fd"\nbuses = ["can0", "can1", ""]\n'
    with (
        served_here(home, buses + boards, time="real") as made,
        canwire.connect(made, name="test") as hub,
        served_site(made) as site,
    ):
        in_order(site, hub)


def in_order(site: Site, hub: canwire.Hub) -> None:
    one, other = canwire.find_lines(hub, "can0")[0], canwire.find_lines(hub, "can1")[0]
    with (
        watching(site, [one.address, other.address]) as viewer,
        sender(hub, "can0") as first,
        sender(hub, "can1") as second,
    ):
        for number in range(500):
            first.send(Frame(number), timeout=LONG_S)
            second.send(Frame(number), timeout=LONG_S)
        viewer.until(lambda one: len(one.frames) == 1000)
        stamps = viewer.rows["record"]["time_ns"]
        assert (stamps[1:] >= stamps[:-1]).all()
        assert viewer.head["late"] == 0


@pytest.mark.finding("page 4")
@pytest.mark.conforms("N-53")
def test_a_snapshot_does_not_drain_and_takes_another_filter(site: Site, hub: canwire.Hub) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    with watching(site, [address]) as viewer, sender(hub) as channel:
        for number in range(10):
            channel.send(Frame(number), timeout=LONG_S)
        viewer.until(lambda one: len(one.frames) == 10)
        until = viewer.head["total"]
        for number in range(10, 20):
            channel.send(Frame(number), timeout=LONG_S)
        viewer.until(lambda one: len(one.frames) == 20)
        viewer.look([address], until=until, number=2)
        viewer.until(lambda one: one.head["look"] == 2 and len(one.frames) == 10)
        assert viewer.head["count"] == len(viewer.rows)
        viewer.look([address], until=until, filter="5-F", number=3)
        viewer.until(lambda one: one.head["look"] == 3 and len(one.frames) == 5)
        assert [frame.id for frame in viewer.frames] == [5, 6, 7, 8, 9]


@pytest.mark.finding("page 6")
@pytest.mark.conforms("PG-01")
def test_made_up_names_cost_nothing(site: Site, hub: canwire.Hub) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    with connect(f"ws://127.0.0.1:{site.port}/trace/live", max_size=None) as socket:
        viewer = Watching(socket, [f"XX{number:06}:0" for number in range(1024)])
        viewer.until(lambda one: one.lines and all(line["trouble"] for line in one.lines))
        assert {line["number"] for line in viewer.lines} == {-1}
    with watching(site, [address]) as viewer:
        assert [line["number"] for line in viewer.lines] == [0]


def test_a_text_is_found_forwards_and_back(site: Site, hub: canwire.Hub) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    with watching(site, [address]) as viewer, sender(hub) as channel:
        for number in (1, 2, 1, 3):
            channel.send(Frame(0x100 + number, b"\xde\xad"), timeout=LONG_S)
        viewer.until(lambda one: len(one.frames) == 4)
        numbers = [int(row["number"]) for row in viewer.rows if row["record"]["info"] & 0xFF == 0]
        places = {}
        asked: tuple[dict[str, Any], ...] = (
            {"find": "101"},
            {"find": "101", "begin": numbers[0]},
            {"find": "dead", "step": -1, "begin": numbers[1]},
            {"find": "777"},
            {"near": numbers[2]},
        )
        for wanted in asked:
            viewer.ask(**wanted)
            viewer.head = {}
            while "found" not in viewer.head:
                viewer.take(viewer.socket.recv(LONG_S))
            places[str(wanted)] = viewer.head["found"]
        assert list(places.values()) == [numbers[0], numbers[2], numbers[0], -1, numbers[2]]


@each(
    "told",
    [
        "",
        "[]",
        "{}",
        '{"look": 7}',
        '{"look": {"number": 1, "lines": [7]}}',
        '{"look": {"number": 1, "lines": [], "since": -1}}',
        '{"ask": {"at": 0, "rows": 99999}}',
        "{" * 5000,
        "x" * 65_537,
    ],
)
@pytest.mark.conforms("PG-01")
def test_a_viewer_that_talks_nonsense_is_let_go(steady: Site, told: str) -> None:
    with connect(f"ws://127.0.0.1:{steady.port}/trace/live") as socket:
        socket.send(told)
        with pytest.raises(ConnectionClosedError) as closed:
            socket.recv(LONG_S)
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code in (1003, 1009)


def test_a_board_that_is_not_there_is_named(site: Site) -> None:
    with connect(f"ws://127.0.0.1:{site.port}/trace/live") as socket:
        viewer = Watching(socket, ["HW999999:0"])
        viewer.until(lambda one: one.lines and one.lines[0]["trouble"])
    assert (
        viewer.lines[0]["trouble"] == "trace.not-plugged-in"
    )  # a word's key: the page says it in its language


def test_the_log_has_every_frame_as_candump_writes_it(
    site: Site, client: httpx.Client, hub: canwire.Hub
) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    frames = [Frame(0x123, b"\x11\x22"), Frame(0x12345678, extended=True), Frame(0x55, bytes(12), fd=True)]
    with watching(site, [address]) as viewer, sender(hub) as channel:
        for frame in frames:
            channel.send(frame, timeout=LONG_S)
        viewer.until(lambda one: len(one.frames) == len(frames))
    answer = client.get("/trace/log", params={"lines": address})
    assert answer.headers["x-canwire-lost"] == "0"
    lines = [canwire.parse_log_line(line) for line in answer.text.splitlines()]
    assert [line.content for line in lines] == frames
    assert {line.interface for line in lines} == {"can0"}
    assert {line.direction for line in lines} == {"T"}


@each("lines", ["", "../etc", "HW1"])
def test_a_log_of_no_line_is_refused(asker: httpx.Client, lines: str) -> None:
    assert asker.get("/trace/log", params={"lines": lines}).status_code == 422


@each("record", ["", "00", "zz" * 80, "ff" * 80, "00" * 81])
def test_a_row_that_is_no_record_is_refused(asker: httpx.Client, record: str) -> None:
    assert asker.get("/trace/row", params={"record": record}).status_code == 422


def test_rows_open_to_their_bits(browser: Browser, site: Site, hub: canwire.Hub) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    with sender(hub) as channel, tab_on_trace(browser, site, address) as page:
        channel.send(Frame(0x12345678, b"\xde\xad\xbe\xef", extended=True), timeout=LONG_S)
        page.locator("#body .trace-row", has_text="DE AD BE EF").wait_for()
        page.locator("#body").focus()
        page.keyboard.press("Home")
        page.keyboard.press("Enter")
        page.locator(".wire svg .level").first.wait_for()
        assert page.locator(".wire rect.stuff").count() > 0
        page.keyboard.press("Escape")
        page.locator("#details").wait_for(state="hidden")


def test_an_error_opens_to_the_frame_that_was_destroyed_and_its_flag(
    browser: Browser, site: Site, hub: canwire.Hub
) -> None:
    """The sender alone is not acknowledged; its frame goes out once a second line joins."""
    first, second = canwire.find_lines(hub, "can0")[:2]
    with (
        canwire.start_line(hub, first, WantedMode(500_000).mode(first.info.capabilities)),
        hub.open_channel(first.board.id, first.line) as channel,
        tab_on_trace(browser, site, first.address) as page,
    ):
        channel.set_up(ChannelMode(receive=8, transmit=8))
        channel.activate()
        channel.send(Frame(0x123, b"\x55"))
        page.locator("#body .trace-row", has_text="ack error").first.wait_for()
        with canwire.start_line(hub, second, WantedMode(500_000).mode(second.info.capabilities)):
            page.locator("#filter").fill("error")
            page.locator("#grid[data-filter=error]").wait_for()
            page.locator("#body").focus()
            page.keyboard.press("Home")
            page.keyboard.press("Enter")
            page.get_by_role("heading", name="ack error").wait_for()
            page.locator("#filter").fill("frame")
            page.locator("#filter").press("Enter")
            page.locator(
                "#grid[data-filter=frame]"
            ).wait_for()  # until then rows of errors have times with 55
            page.locator("#body .trace-row:not([hidden])", has_text="55").first.wait_for()
            page.locator("#filter").fill("error")
            page.locator("#grid[data-filter=error]").wait_for()
            page.locator("#body").focus()
            page.keyboard.press("Home")
            page.keyboard.press("Enter")
            page.locator(".wire rect.error").first.wait_for()
            assert "123#55" in page.locator(".wire figcaption").inner_text()


@pytest.mark.finding("page 5")
def test_one_row_for_each_identifier_counts_and_marks_what_changed(
    browser: Browser, site: Site, hub: canwire.Hub
) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    with sender(hub) as channel, tab_on_trace(browser, site, address) as page:
        page.get_by_role("button", name="By identifier").click()
        for number in range(5):
            for identifier in (0x200, 0x100):
                channel.send(Frame(identifier, bytes([7, number])), timeout=LONG_S)
        rows = rows_with(page, data="07")
        for place in (0, 1):
            rows.nth(place).locator(".c-count", has_text="5").wait_for()
        assert [row.locator(".c-id").inner_text() for row in rows.all()] == ["100", "200"]
        later = itertools.cycle(range(0x10, 0x100))
        while not (marked := rows.first.locator("b").all_inner_texts()):  # a mark fades within a second
            channel.send(Frame(0x100, bytes([7, next(later)])), timeout=LONG_S)
        assert len(marked) == 1
        assert marked != ["07"]


def send_out_of_sight(channel: canwire.HubChannel, page: Page, row: Locator) -> None:
    """Send so much that this one is above what is seen."""
    for _ in range(200):
        channel.send(Frame(0x200), timeout=LONG_S)
    page.locator("#shown", has_text="201").wait_for()
    row.wait_for(state="detached")


def test_a_chosen_row_that_has_gone_out_of_sight_is_marked(
    browser: Browser, site: Site, hub: canwire.Hub
) -> None:
    """New rows go on coming until the server has said what is in the chosen one; then "m" did nothing."""
    address = canwire.find_lines(hub, "can0")[0].address
    with sender(hub) as channel, tab_on_trace(browser, site, address) as page:
        page.route("**/trace/row*", lambda route: None)  # no answer
        channel.send(Frame(0x101), timeout=LONG_S)
        row = page.locator("#body .trace-row .c-id", has_text="101")
        row.click()
        send_out_of_sight(channel, page, row)
        page.keyboard.press("m")
        page.get_by_role("button", name="Next mark").click()
        page.locator("#body .trace-row.marked[aria-selected=true] .c-id", has_text="101").wait_for()


def test_the_menu_of_a_row_that_has_gone_out_of_sight(browser: Browser, site: Site, hub: canwire.Hub) -> None:
    """Its row goes on while somebody reads it."""
    address = canwire.find_lines(hub, "can0")[0].address
    with sender(hub) as channel, tab_on_trace(browser, site, address) as page:
        channel.send(Frame(0x101), timeout=LONG_S)
        row = page.locator("#body .trace-row .c-id", has_text="101")
        row.click(button="right")
        send_out_of_sight(channel, page, row)
        page.get_by_role("menuitem", name="Only this").click()
        row.wait_for()
        assert page.locator("#filter").input_value() == "id:101"


def test_a_row_by_identifier_that_a_new_one_moves(browser: Browser, site: Site, hub: canwire.Hub) -> None:
    """Its menu, which is open, and its choice are not the moved row's neighbour's."""
    address = canwire.find_lines(hub, "can0")[0].address
    with sender(hub) as channel, tab_on_trace(browser, site, address) as page:
        page.get_by_role("button", name="By identifier").click()
        for identifier in (0x300, 0x400):
            channel.send(Frame(identifier), timeout=LONG_S)
        rows_with(page, id="400").wait_for()
        rows_with(page, id="300").click(button="right")
        channel.send(Frame(0x200), timeout=LONG_S)
        rows_with(page, id="200").wait_for()
        assert page.locator("#body .trace-row[aria-selected=true] .c-id").all_inner_texts() == ["300"]
        page.get_by_role("menuitem", name="Open").click()
        page.locator("#opened", has_text="300").wait_for()
        rows_with(page, id="300").click(button="right")
        channel.send(Frame(0x100), timeout=LONG_S)
        rows_with(page, id="100").wait_for()
        page.get_by_role("menuitem", name="Only this").click()
        page.locator('#grid[data-filter="id:300"]').wait_for()


def test_a_line_that_comes_to_run_hides_no_rows(browser: Browser, site: Site, hub: canwire.Hub) -> None:
    """Who has chosen no lines goes on watching the one that runs, though an earlier one of its bus has come to run."""
    first, second, *_ = canwire.find_lines(hub, "can0")
    mode = WantedMode(500_000).mode(first.info.capabilities)
    with canwire.start_line(hub, second, mode), tab(browser, at(site, "trace")) as page:
        lines = page.locator("#lines")
        lines.locator("label.running", has_text=second.address).wait_for()
        page.locator("body[data-listening=yes]").wait_for()
        with canwire.start_line(hub, first, mode), hub.open_channel(first.board.id, first.line) as channel:
            channel.set_up(ChannelMode(receive=8, transmit=8))
            channel.activate()
            channel.send(Frame(0x101, b"\x11\x22"), timeout=LONG_S)
            page.locator("#body .trace-row", has_text="11 22").wait_for()
            lines.locator("label.running", has_text=first.address).wait_for()
            assert not lines.get_by_label(first.address).is_checked()
            assert lines.get_by_label(second.address).is_checked()


def test_a_chosen_row_by_time_while_the_oldest_go(browser: Browser, site: Site, hub: canwire.Hub) -> None:
    """The row at place 7 has index 7 in the list, then 2, then it is gone."""
    address = canwire.find_lines(hub, "can0")[0].address
    with tab_on_trace(browser, site, address) as page:
        found = page.evaluate("""async () => {
            const { src } = document.querySelector("script[src*='trace/trace.js']");
            const { Known } = await import(src.replace("trace.js", "known.js"));
            const list = { dropped() {} };
            const known = new Known(list, { rows: { has: () => false } }, () => false);
            return [0, 5, 9].map((gone) => {
                known.answered({ gone });
                return [known.indexOf({ place: 7 }), known.placeOf(2)];
            });
        }""")
    assert found == [[7, 2], [2, 7], [-1, 11]]


@pytest.mark.finding("page 13")
def test_pause_search_and_what_is_remembered(browser: Browser, site: Site, hub: canwire.Hub) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    with sender(hub) as channel, tab_on_trace(browser, site, address) as page:
        channel.send(Frame(0x101), timeout=LONG_S)
        channel.send(Frame(0x102), timeout=LONG_S)
        page.locator("#shown", has_text="2").wait_for()
        page.locator("#body").focus()
        page.keyboard.press("Space")
        page.get_by_role("button", name="Continue").wait_for()
        channel.send(Frame(0x103), timeout=LONG_S)
        page.locator("#kept", has_text="3").wait_for()
        assert page.locator("#shown").inner_text() == "2"
        page.get_by_role("button", name="Continue").click()
        page.locator("#shown", has_text="3").wait_for()
        page.keyboard.press("/")
        page.keyboard.type("102")
        page.keyboard.press("Enter")
        page.locator("#body .trace-row[aria-selected=true] .c-id", has_text="102").wait_for()
        page.locator("#search").fill("nothing like it")
        page.keyboard.press("Enter")
        page.get_by_text("is not found in these rows").wait_for()
        page.locator("#filter").fill("zzz")
        page.locator("#filter").press("Enter")
        page.get_by_text("“zzz” is not an identifier, range, name, signal or filter word.").wait_for()
        page.locator("#filter").fill("!102")
        page.locator("#filter").press("Enter")
        page.locator("#shown", has_text="2").wait_for()
        page.locator("#pause").click()
        channel.send(Frame(0x104), timeout=LONG_S)
        page.reload()
        holds(page.locator("#filter"), "!102")
        page.locator("#shown", has_text="2").wait_for()  # from the server's history
        page.get_by_role("button", name="Continue").click()
        page.locator("#shown", has_text="3").wait_for()


@pytest.mark.finding("page 1")
@pytest.mark.conforms("PG-04")
def test_a_viewer_that_does_not_read_slows_nobody_and_misses_nothing(site: Site, hub: canwire.Hub) -> None:
    """Rows are put into the history directly: more than memory holds. What it does not ask for is not sent."""
    address = canwire.find_lines(hub, "can0")[0].address
    with watching(site, [address]) as reading, watching(site, [address]) as sleeping:
        history = site.desk.kept["trace"].history
        before = len(reading.rows)
        records = canwire.frames_to_array([Frame(1, bytes(8))] * 4000)
        for _ in range(40):
            history.append(rows_of(records, 0))
        reading.until(lambda one: len(one.rows) == before + 160_000)
        sleeping.until(lambda one: len(one.rows) == before + 160_000)
        assert sleeping.rows.tobytes() == reading.rows.tobytes()
