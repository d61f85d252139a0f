"""What people do at a bus on a Monday, each by clicks in the browser, which are counted; docs/web.md has the table."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest

import canwire
from canwire import ChannelMode, Frame, LogEntry, WantedMode
from tests.hubs import LONG_S, serving
from tests.web.conftest import at, counts, served_site, tab

pytest.importorskip("cantools")
if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, Page

    from canwire.web.server import Site

pytestmark = pytest.mark.conforms("PG-02", "PG-03", "N-54")

DBC = """VERSION ""
BU_: ECU
BO_ 256 Engine: 8 ECU
 SG_ Speed : 0|16@1+ (0.25,0) [0|16000] "rpm" ECU
"""
CYCLE_S = 0.02
ROWS = "#body .trace-row:not([hidden])"
STAMP_NS = 1_700_000_000_000_000_000


class Desk(NamedTuple):
    """A car on can0, its page, and files."""

    site: Site
    hub: canwire.Hub
    line: str
    other: str
    lin: str
    log: Path
    dbc: Path


def drive(hub: canwire.Hub, place: canwire.LinePlace, ends: threading.Event) -> None:
    """Two frames that change, in their cycles."""
    with hub.open_channel(place.board.id, place.line) as channel:
        channel.set_up(ChannelMode(receive=8, transmit=64))
        channel.activate()
        number = 0
        while not ends.wait(CYCLE_S):
            number += 1
            channel.send(Frame(0x100, (4000 + number % 100).to_bytes(8, "little")), timeout=LONG_S)
            channel.send(Frame(0x200, bytes([0xDE, 0xAD, number & 0xFF])), timeout=LONG_S)


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    home = tmp_path_factory.mktemp("monday")
    dbc, log = home / "car.dbc", home / "drive.asc"
    dbc.write_text(DBC)
    with canwire.create_log(log) as writer:
        for number in range(20):
            stamp_ns = STAMP_NS + number * 1_000_000
            frame = Frame(0x300 + number, bytes([number]), timestamp_ns=stamp_ns)
            writer.write_many([LogEntry(stamp_ns, "can0", frame, "R")])
    with ExitStack() as closing:
        address = closing.enter_context(serving(home, time="real")).address
        hub = closing.enter_context(canwire.connect(address, name="car"))
        places = canwire.find_lines(hub, "can0")
        for place in places[:2]:
            mode = WantedMode(500_000).mode(place.info.capabilities)
            closing.enter_context(canwire.start_line(hub, place, mode))
        ends = threading.Event()
        driving = threading.Thread(target=drive, args=(hub, places[1], ends))
        driving.start()
        closing.callback(driving.join)
        closing.callback(ends.set)
        site = closing.enter_context(served_site(address, [str(dbc)]))
        lin = canwire.find_lines(hub, "lin0")[0].address
        yield Desk(site, hub, places[0].address, places[2].address, lin, log, dbc)


class User:
    """Somebody at the page, whose clicks are counted; what is typed is not."""

    def __init__(self, page: Page, desk: Desk) -> None:
        self.page = page
        self.desk = desk
        self.clicks = 0

    def click(self, what: str | re.Pattern[str] | Locator, **options: object) -> None:
        """A button by its name, or anything else."""
        found = self.page.get_by_role("button", name=what) if isinstance(what, (str, re.Pattern)) else what
        found.click(**options)  # type: ignore[arg-type]
        self.clicks += 1

    def rows(self, text: str | re.Pattern[str]) -> Locator:
        return self.page.locator(ROWS, has_text=text)

    def choose(self, what: str, file: Path) -> None:
        """A file, by a button of this name."""
        with self.page.expect_file_chooser() as choosing:
            self.click(what)
        choosing.value.set_files(file)


class Task(NamedTuple):
    view: str
    text: str
    clicks: int
    do: Callable[[User], None]


TASKS: list[Task] = []


def task(view: str, text: str, clicks: int) -> Callable[[Callable[[User], None]], Callable[[User], None]]:
    def listed(do: Callable[[User], None]) -> Callable[[User], None]:
        TASKS.append(Task(view, text, clicks, do))
        return do

    return listed


@task("boards", "start a line at a bit rate", 2)
def start_a_line(user: User) -> None:
    user.click(f"Start {user.desk.other}")
    user.page.get_by_label("Bit rate", exact=False).first.fill("500000")
    user.click(user.page.locator("#up-dialog button.main"))
    user.page.get_by_role("button", name=f"Stop {user.desk.other}").wait_for()


@task("boards", "see what happens on the bus that runs", 1)
def see_traffic(user: User) -> None:
    user.click(user.page.get_by_role("link", name="Trace"))
    user.rows("DE AD").first.wait_for()


@task("trace", "see which frames there are, with their cycles", 1)
def by_identifier(user: User) -> None:
    user.click("By identifier")
    user.rows("DE AD").locator(".c-cycle", has_text=re.compile(r"\d")).wait_for()


@task("trace", "see a signal's value live", 1)
def live_signal(user: User) -> None:
    user.click("By identifier")
    user.rows(re.compile(r"Speed 10\d\d")).wait_for()


@task("trace", "plot a signal", 2)
def plot(user: User) -> None:
    user.click("By identifier")
    user.click(user.page.get_by_role("button", name=re.compile("^Speed")).first)
    user.page.locator("#plot canvas").wait_for()


@task("trace", "show one message alone, by its name", 1)
def filter_by_name(user: User) -> None:
    user.click(user.page.locator("#filter"))
    user.page.keyboard.type("engine")
    user.page.locator('#grid[data-filter="engine"]').wait_for()
    counts(user.rows("DE AD"), 0)


@task("trace", "show frames in which a signal is above a value", 1)
def filter_by_signal(user: User) -> None:
    user.click(user.page.locator("#filter"))
    user.page.keyboard.type("Speed > 1020")
    user.page.locator('#grid[data-filter="Speed > 1020"]').wait_for()
    user.rows("Engine").first.wait_for()
    counts(user.rows("A0 0F"), 0)  # 1000 rpm


@task("trace", "show only rows like this one", 3)
def only_this(user: User) -> None:
    user.click("Pause")
    user.click(user.rows("DE AD").first, button="right")
    user.click(user.page.get_by_role("menuitem", name="Only this"))
    user.page.locator('#grid[data-filter="id:200"]').wait_for()


@task("trace", "pause the list, and go back to its beginning", 1)
def pause(user: User) -> None:
    user.click("Pause")
    user.page.locator("#body").focus()
    user.page.keyboard.press("Home")
    user.page.locator('#body .trace-row[aria-rowindex="2"]').wait_for()


@task("trace", "look for bytes", 1)
def search(user: User) -> None:
    user.click(user.page.locator("#search"))
    user.page.keyboard.type("DE AD")
    user.page.keyboard.press("Enter")
    user.page.locator('#body .trace-row[aria-selected="true"]', has_text="DE AD").wait_for()


@task("trace", "see a frame's signals and its bits on the wire", 1)
def open_row(user: User) -> None:
    user.page.keyboard.press("f")  # rows move: the one that is clicked on is whichever is there then
    user.page.keyboard.type("engine")
    user.page.locator('#grid[data-filter="engine"]').wait_for()
    counts(user.rows("DE AD"), 0)
    user.click(user.rows("Engine").first)
    user.page.locator(".wire svg").wait_for()
    user.page.locator("#opened", has_text="rpm").wait_for()


@task("trace", "mark a row, and come back to it", 2)
def mark(user: User) -> None:
    user.click(user.rows("DE AD").first)
    user.page.keyboard.press("m")
    user.page.keyboard.press("End")
    user.click("Next mark")
    user.page.locator("#body .trace-row.marked[aria-selected=true]").wait_for()


@task("trace", "see the time of day, and the distance to the row before", 4)
def wall_clock(user: User) -> None:
    user.click("View…")
    user.click(user.page.locator("#columns").get_by_label("Clock"))
    user.click(user.page.locator("#columns").get_by_label("Delta"))
    user.click(user.page.locator("#colours").get_by_role("button", name="Close"))
    user.rows(re.compile(r"\d\d:\d\d:\d\d\.\d+")).first.wait_for()


@task("trace", "save what is shown as BLF", 2)
def save(user: User) -> None:
    user.rows("Engine").first.wait_for()
    user.click("Save log…")
    user.page.get_by_label("Format of the file").select_option("blf")
    with user.page.expect_download() as downloading:
        user.click(user.page.locator("#save-now"))
    with canwire.open_log(downloading.value.path(), format="blf") as saved:
        assert 0x100 in {entry.frame.id for entry in saved if entry.frame is not None}


@task("trace", "open a log", 1)
def open_log(user: User) -> None:
    user.choose("Open log…", user.desk.log)
    user.rows("301").first.wait_for()  # times have these digits, too
    user.page.locator("#shown", has_text="20").wait_for()


@task("trace", "replay a log onto the bus at double speed", 3)
def replay(user: User) -> None:
    user.choose("Open log…", user.desk.log)
    user.click("Replay…")
    user.page.get_by_label("Speed").fill("2")
    user.click("Start the replay")
    user.page.get_by_text("20 frames sent, 20 acknowledged or heard").wait_for()


@task("trace", "load a database", 3)
def load_database(user: User) -> None:
    user.click("Databases…")
    user.choose("Open file…", user.desk.dbc)
    user.page.get_by_text("car.dbc is open, with 1 messages.").wait_for()
    user.click(user.page.locator("#databases").get_by_role("button", name="Close", exact=True))


@task("trace", "send a frame beside the trace", 4)
def send(user: User) -> None:
    user.click(user.page.locator("#beside summary"))
    new_row(user, "7A1", "11 22")
    user.page.locator("#filter").fill("7A1")  # among all the others it is in sight for a moment only
    user.page.locator('#grid[data-filter="7A1"]').wait_for()
    user.click(re.compile(r"^Send \d"))
    user.rows("7A1").first.wait_for()


@task("trace", "send a frame in its cycle, and change its data meanwhile", 5)
def cycle(user: User) -> None:
    user.click(user.page.locator("#beside summary"))
    new_row(user, "7A2", "11 22", cycle="20")
    user.click(re.compile(r"^Cycle \d"))
    user.rows("7A2").first.wait_for()
    field = user.page.locator("#list [name=data]")
    user.click(field)
    field.fill("AB CD")
    field.press("Enter")
    user.rows(re.compile("7A2.*AB CD")).first.wait_for()


@task("send", "start a LIN line as master, and run a schedule", 3)
def lin(user: User) -> None:
    user.click("LIN…")
    user.page.locator("#lin-form [name=line]").select_option(user.desk.lin)
    user.click("Start the line")
    user.page.get_by_text("is the master of its bus").wait_for()
    user.page.locator("#schedule-form [name=slots]").fill("10#0102@10ms 11:2@10ms")
    user.click("Run the schedule")
    user.page.get_by_text("The hub runs a schedule").wait_for()


def new_row(user: User, identifier: str, data: str, cycle: str = "") -> None:
    """Two clicks."""
    user.click("New…")
    user.page.locator("#row-form [name=line]").select_option(user.desk.line)
    user.page.get_by_label("Identifier, hex").fill(identifier)
    user.page.get_by_label("Data bytes, hex").fill(data)
    user.page.get_by_label("Cycle, ms").fill(cycle)
    user.click("Keep")
    user.page.locator("#row-dialog").wait_for(state="hidden")  # nothing behind it takes keys before


@pytest.mark.finding("page D1")
@pytest.mark.parametrize("wanted", TASKS, ids=[one.text for one in TASKS])
def test_it_takes_so_many_clicks(browser: Browser, desk: Desk, wanted: Task) -> None:
    with tab(browser, at(desk.site, wanted.view)) as page:
        if wanted.view == "trace":
            page.locator("body[data-listening=yes]").wait_for()
        user = User(page, desk)
        try:
            wanted.do(user)
        finally:
            # the server may have closed a connection that rested for a while: then over a new one
            listed = page.request.get(f"{desk.site.url}send/list", max_retries=3).text()
            for number in re.findall(r'data-row="(\d+)"', listed):
                page.request.post(f"{desk.site.url}send/remove", form={"number": number}, max_retries=3)
        assert user.clicks == wanted.clicks


def test_the_page_s_documentation_has_them_all() -> None:
    text = (Path(__file__).parents[2] / "docs" / "web.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| (.+?) \| (\d+) \|$", text, re.M)
    assert [(one.text, str(one.clicks)) for one in TASKS] == listed
    assert len(TASKS) == 20
