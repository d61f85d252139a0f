"""`canwire acan spy`: CANSPY's notation, its banner and trace, what it does to the filters, and its window."""

from __future__ import annotations

import asyncio
import itertools
import re
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadText, Frame, HubLost, InUse, QueueFull, acan
from canwire.commands import main
from canwire.commands.acan.conditions import bus_error
from canwire.commands.acan.machines import config_of, set_up
from canwire.commands.acan.spy import CREDIT, Spy, Trace, banner
from canwire.commands.acan.term import Terminal
from canwire.commands.acan.trace import format_message, format_trace_line, parse_message, parse_trace_line
from tests import warm
from tests.commands.acan.bench import LONG_S, ONE, TWO, Bench
from tests.commands.acan.double import Wire
from tests.commands.acan.screen import ON_DOUBLE, OpenScreen, environment
from tests.commands.idle import piloted

MANUALS = """\
10:04:17 - 00001001000 - 61 | a
10:04:17 - 00001001000 - 62 | b
10:04:17 - 00001001000 - 63 | c
10:04:18 - 00001001000 - 30 31 32 33 34 35 36 37 | 01234567
10:04:18 - 00001001000 - 38 39 41 42 43 44 45 46 | 89ABCDEF
10:04:37 - 00001001000 - 68 | h
10:04:37 - 00001001000 - 65 | e
10:04:37 - 00001001000 - 6C | l
10:04:37 - 00001001000 - 6C | l
10:04:37 - 00001001000 - 6F | o""".splitlines()

# the notation


@pytest.mark.conforms("AT-08")
@pytest.mark.parametrize("line", MANUALS)
def test_the_manuals_lines(line: str) -> None:
    clock, frame = parse_trace_line(line)
    assert frame.id == 0b00001001000
    assert not frame.extended
    assert format_trace_line(clock, frame) == line


@pytest.mark.conforms("AT-08")
@pytest.mark.parametrize(
    ("frame", "text"),
    [
        (Frame(0x7FF, b""), "11111111111 -"),
        (Frame(0x001, b"\x00\x7f\xff ~"), "00000000001 - 00 7F FF 20 7E | ... ~"),
        (Frame(0x001, b"|"), "00000000001 - 7C | |"),
        (Frame(0x1FFFFFFF, b"x", extended=True), "1" * 29 + " - 78 | x"),
        (Frame(1, extended=True), "0" * 28 + "1 -"),
        (Frame(0x048, remote=True), "00001001000 R"),
        (Frame(0x048, remote=True, dlc=8), "00001001000 R 8"),
    ],
)
def test_notation(frame: Frame, text: str) -> None:
    assert format_message(frame) == text
    assert parse_message(text) == frame


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    extended = draw(st.booleans())
    id = draw(st.integers(0, 0x1FFFFFFF if extended else 0x7FF))
    if draw(st.booleans()):
        return Frame(id, extended=extended, remote=True, dlc=draw(st.integers(0, 8)))
    return Frame(id, draw(st.binary(max_size=8)), extended=extended)


@pytest.mark.conforms("AT-08", "AT-10")
@given(frames(), st.times())
def test_round_trip(frame: Frame, time: Any) -> None:
    clock = time.strftime("%H:%M:%S")
    line = format_trace_line(clock, frame)
    assert parse_trace_line(line) == (clock, frame)
    assert parse_message(line) == parse_message(format_message(frame)) == frame
    assert parse_message(f"  {format_message(frame)}  ") == frame


@pytest.mark.conforms("AT-10")
@pytest.mark.parametrize(
    ("text", "frame"),
    [
        ("00001001000 - 61 62", Frame(0x48, b"ab")),
        ("00001001000 - 6c 6C", Frame(0x48, b"ll")),
        ("00001001000 - | ab c", Frame(0x48, b"ab c")),
        ("00001001000 -|ab", Frame(0x48, b"ab")),
        ("00001001000 - | ÿ", Frame(0x48, b"\xff")),
        ("00001001000 - 61 |", Frame(0x48, b"a")),
        ("00001001000 -", Frame(0x48)),
        ("00001001000 - |", Frame(0x48)),
        ("00001001000 r 2", Frame(0x48, remote=True, dlc=2)),
    ],
)
def test_what_may_be_sent(text: str, frame: Frame) -> None:
    assert parse_message(text) == frame


@pytest.mark.conforms("AT-10")
@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "like 00001001000 - 61 62"),
        ("00001001000", "like 00001001000"),
        ("00001001000 X 61", "like 00001001000"),
        ("00001001002 - 61", "like 00001001000"),
        ("00001001000 -61", "like 00001001000"),
        ("0000100100 - 61", "10 binary digits; an identifier has 11, or 29 if extended"),
        ("00001001000 - 6", "'6' are no bytes of two hexadecimal digits; characters stand behind |"),
        ("00001001000 - hello", "'hello' are no bytes"),
        ("00001001000 - 6162", "'6162' are no bytes"),
        ("00001001000 - 61 | b", "the bytes read 'a'; give them or the characters, not both"),
        ("00001001000 - 01 02 03 04 05 06 07 08 09", "9 bytes; a message has 8 at most"),
        ("00001001000 - | 123456789", "9 bytes; a message has 8 at most"),
        ("00001001000 - | €", "not all of these characters are bytes"),
        ("00001001000 R 9", "the number of bytes asked for, 0 to 8"),
        ("00001001000 R 61 62", "the number of bytes asked for, 0 to 8"),
    ],
)
def test_what_is_no_message(text: str, why: str) -> None:
    with pytest.raises(BadText) as caught:
        parse_message(text)
    assert why in str(caught.value)


def test_a_trace_line_has_a_time() -> None:
    with pytest.raises(BadText, match="no time hh:mm:ss in front"):
        parse_trace_line("00001001000 - 61 | a")


@given(st.text(alphabet="01 -R|6aX:\n", max_size=40))
def test_anything_else_is_bad_text(text: str) -> None:
    try:
        frame = parse_message(text)
    except BadText:
        return
    assert parse_message(format_message(frame)) == frame


# the banner


@pytest.mark.conforms("AT-07", "AC-12")
def test_the_banner() -> None:
    lines = [*banner((1, 0), acan.HardConfig(), before=True)]
    assert lines == [
        "CAN Spy - Version 1.0",
        CREDIT,
        "",
        "ACAN.DLL Version 1.0",
        "",
        "VACAND Driver Version 1.0",
        "",
        "Philips SJA1000 CAN Controller detected",
        "Hardware was previously initialized",
        "",
        "Clock: 16000 KHz, Rate: 250 Kbps",
        "TSEG1 = 11, TSEG2 = 5, SJW = 3, MSI = 1",
        "",
    ]
    assert CREDIT.startswith("*** ")


# the trace


class Clock:
    """A second later at every look."""

    def __init__(self) -> None:
        self._seconds = itertools.count(1)

    def __call__(self) -> str:
        return f"10:04:{next(self._seconds):02d}"


def traced() -> tuple[Trace, list[str]]:
    shown: list[str] = []
    return Trace(lambda: "10:04:01", shown.append), shown


@pytest.mark.conforms("AT-09")
def test_the_last_800_messages_are_kept() -> None:
    trace, shown = traced()
    trace.write("CAN Spy")
    trace.resume()
    trace.take([Frame(number) for number in range(799)])
    assert len(trace.lines) == 801
    trace.take([Frame(799)])
    assert trace.lines[:2] == ["CAN Spy", "10:04:01 - TRACE IS ON"]
    trace.take([Frame(number) for number in range(800, 900)])
    assert trace.lines == [f"10:04:01 - {number:011b} -" for number in range(100, 900)]
    assert len(shown) == 902
    assert trace.taken == 900


def test_other_lines_are_forgotten_at_last() -> None:
    trace, _ = traced()
    trace.resume()
    for _ in range(10):
        trace.take([Frame(1)])
        for _ in range(400):
            trace.note("bus error")
    assert len(trace.lines) == 1600
    trace.take([Frame(2)] * 801)
    assert trace.lines == ["10:04:01 - 00000000010 -"] * 800


@pytest.mark.conforms("AT-09")
def test_pause_and_resume() -> None:
    trace, shown = traced()
    trace.resume()
    trace.take([Frame(1)])
    trace.pause()
    trace.take([Frame(2), Frame(3)])
    trace.resume()
    trace.take([Frame(4)])
    assert (
        shown
        == trace.lines
        == [
            "10:04:01 - TRACE IS ON",
            "10:04:01 - 00000000001 -",
            "10:04:01 - TRACE IS OFF",
            "10:04:01 - 2 messages passed by",
            "10:04:01 - TRACE IS ON",
            "10:04:01 - 00000000100 -",
        ]
    )


@pytest.mark.conforms("AT-09")
def test_clear() -> None:
    trace, _ = traced()
    trace.resume()
    trace.take([Frame(1)] * 800)
    trace.clear()
    assert trace.lines == []
    trace.take([Frame(2)] * 801)
    assert len(trace.lines) == 800


@pytest.mark.conforms("AT-09")
def test_redirect(tmp_path: Path) -> None:
    trace, shown = traced()
    file, other = tmp_path / "trace.txt", tmp_path / "other.txt"
    file.write_text("before\n")
    trace.resume()
    trace.redirect(file)
    trace.take([Frame(0x48, b"a")])
    trace.clear()
    trace.redirect(other)
    trace.take([Frame(0x48, b"b")])
    trace.redirect(None)
    trace.take([Frame(0x48, b"c")])
    assert file.read_text() == "before\n10:04:01 - 00001001000 - 61 | a\n"
    assert other.read_text() == "10:04:01 - 00001001000 - 62 | b\n"
    assert len(shown) == 4
    with pytest.raises(OSError, match="No such file"):
        trace.redirect(tmp_path / "nowhere" / "trace.txt")


def test_a_full_disk_ends_the_redirection() -> None:
    trace, shown = traced()
    trace.resume()
    trace.redirect(Path("/dev/full"))
    trace.take([Frame(1)])
    trace.flush()
    assert shown[-1].startswith("10:04:01 - no longer redirected: ")
    trace.take([Frame(1)])
    trace.flush()
    trace.close()


# at work


def spying(driver: Any, clock: Any = lambda: "10:04:01") -> tuple[Spy, list[str]]:
    shown: list[str] = []
    return Spy(driver, Trace(clock, shown.append)), shown


@pytest.mark.conforms("AT-07", "AT-08")
def test_the_manuals_trace() -> None:
    """Its program on another machine sends to all of them."""
    wire = Wire()
    other = wire.driver()
    set_up(other, 1)
    terminal = Terminal(other, 1, 0)
    spy, shown = spying(wire.driver(config_of(2), on_bus=True))
    spy.start()
    assert shown[8:] == [
        "Hardware was previously initialized",
        "",
        "Clock: 16000 KHz, Rate: 250 Kbps",
        "TSEG1 = 11, TSEG2 = 5, SJW = 3, MSI = 1",
        "",
        "10:04:01 - Hardware is initialized",
        "10:04:01 - TRACE IS ON",
    ]
    del shown[:]
    for keys in (b"a", b"b", b"c", b"\x15", b"h", b"e", b"l", b"l", b"o"):
        terminal.typed(keys)
    spy.take()
    assert [line[11:] for line in shown] == [line[11:] for line in MANUALS]


@pytest.mark.conforms("AT-07")
def test_a_controller_nobody_has_set_up() -> None:
    driver = Wire().driver()
    spy, shown = spying(driver)
    spy.start(16_000, 125)
    assert shown[8:12] == [
        "Hardware was not initialized",
        "",
        "Clock: 16000 KHz, Rate: 125 Kbps",
        "TSEG1 = 11, TSEG2 = 5, SJW = 3, MSI = 1",
    ]
    assert driver.on_bus
    spy.stop()
    assert driver.on_bus
    assert driver.blocks == []


@pytest.mark.conforms("AT-11")
def test_it_opens_the_filters_and_puts_them_back() -> None:
    wire = Wire()
    before = acan.HardConfig(
        machine_id=2 << 18, machine_mask=7 << 18, broadcast_mask=7 << 18, rate_kbps=125, sjw=2
    )
    driver = wire.driver(before, on_bus=True)
    spy, shown = spying(driver)
    spy.start()
    config = driver.config()
    assert (config.machine_mask, config.broadcast_mask) == (0, 0)
    assert (config.machine_id, config.rate_kbps, config.sjw) == (2 << 18, 125, 2)
    assert (driver.held, driver.on_bus) == (True, True)
    for frame in (Frame(0x7FF, b"\x01"), Frame(0x1FFFFFFF, extended=True), Frame(3, remote=True)):
        wire.put(frame)
    spy.take()
    assert [line[11:] for line in shown[-3:]] == ["1" * 11 + " - 01 | .", "1" * 29 + " -", "00000000011 R"]
    spy.stop()
    spy.stop()
    assert (driver.config(), driver.held, driver.on_bus) == (before, False, True)


def test_a_controller_that_was_off_the_bus_is_off_again() -> None:
    driver = Wire().driver(config_of(2), on_bus=False)
    spy, _ = spying(driver)
    spy.start()
    assert driver.on_bus
    spy.stop()
    assert (driver.config(), driver.on_bus) == (config_of(2), False)


@pytest.mark.conforms("AT-11")
def test_two_spies_cannot_hold_the_same_filters() -> None:
    driver = Wire().driver(config_of(2), on_bus=True)
    driver.holder = "another spy"
    spy, shown = spying(driver)
    with pytest.raises(InUse, match="another spy"):
        spy.start()
    assert (shown, driver.done) == ([], [])
    spy.stop()


@pytest.mark.conforms("AT-10")
def test_one_shot_send() -> None:
    wire = Wire()
    driver = wire.driver()
    spy, shown = spying(driver)
    spy.start()
    spy.send("00001001000 - | hello")
    spy.send("10:04:17 - 00001001000 R 3")
    assert wire.frames == [Frame(0x48, b"hello"), Frame(0x48, remote=True, dlc=3)]
    assert shown[-2:] == [
        "10:04:01 - Sent: 00001001000 - 68 65 6C 6C 6F | hello",
        "10:04:01 - Sent: 00001001000 R 3",
    ]
    with pytest.raises(BadText):
        spy.send("hello")
    driver.full = True
    with pytest.raises(QueueFull):
        spy.send("00000000000 -")
    assert list(spy.sent) == ["00001001000 R 3", "00001001000 - 68 65 6C 6C 6F | hello"]


@pytest.mark.conforms("AT-10")
def test_the_last_ten_sent_messages_are_kept() -> None:
    spy, _ = spying(Wire().driver())
    spy.start()
    for number in range(12):
        spy.send(f"{number:011b} -")
    assert list(spy.sent) == [f"{number:011b} -" for number in range(11, 1, -1)]
    spy.send("00000000101 -")
    assert list(spy.sent)[:2] == ["00000000101 -", "00000001011 -"]
    assert len(spy.sent) == 10


@pytest.mark.conforms("AT-09")
def test_trace_is_paused_and_resumed() -> None:
    wire = Wire()
    driver = wire.driver()
    spy, shown = spying(driver)
    spy.start()
    del shown[:]
    wire.put(Frame(1))
    spy.toggle()
    wire.put(Frame(2))
    spy.take()
    driver.on_bus = False
    spy.toggle()
    wire.put(Frame(3))
    spy.take()
    assert [line[11:] for line in shown] == [
        "00000000001 -",
        "TRACE IS OFF",
        "1 messages passed by",
        "TRACE IS ON",
        "00000000011 -",
    ]


@pytest.mark.finding("acan A15.8")
def test_what_the_bus_does() -> None:
    driver = Wire().driver()
    spy, shown = spying(driver)
    spy.start()
    driver.happen(acan.Condition.BUSERR | acan.Condition.ERRPAS, ecc=0x28, tec=128, rec=3)
    spy.take()
    driver.happen(acan.Condition.OVERRUN | acan.Condition.NOBUFF | acan.Condition.BUSOFF)
    spy.take()
    assert shown[-5:] == [
        "10:04:01 - bit error at the CRC, receiving",
        "10:04:01 - error passive: TEC 128, REC 3",
        "10:04:01 - bus-off: the error counters are full",
        "10:04:01 - the controller lost messages: nobody took them in time",
        "10:04:01 - the driver lost messages: it has no buffer left",
    ]


def test_what_comes_faster_than_it_is_taken_is_told() -> None:
    wire = Wire()
    spy, shown = spying(wire.driver())
    spy.start()
    for _ in range(801):
        wire.put(Frame(1))
    spy.take()
    assert shown[-1].endswith("messages were lost: they came faster than they were taken")


@pytest.mark.parametrize(
    ("code", "text"),
    [
        (0xD9, "bus error at the acknowledge slot, sending: nobody acknowledges"),
        (0xF9, "bus error at the acknowledge slot, receiving"),
        (0x4A | 0x20, "form error at the data, receiving"),
        (0x80, "stuff error, sending"),
    ],
)
def test_error_codes(code: int, text: str) -> None:
    assert bus_error(code) == text


# the window


def window(driver: Any, file: Path | None = None, messages: tuple[str, ...] = ()) -> Any:
    screens = pytest.importorskip("canwire.commands.acan.spy_screen")
    return screens.SpyScreen(driver, (16_000, 250), file, messages)


def lines(app: Any) -> list[str]:
    return [line[11:] if line[2:3] == ":" else line for line in app.screen_stack[0].query_one("#trace").lines]


def status(app: Any) -> str:
    return str(app.screen_stack[0].query_one("#status").content)


@pytest.mark.conforms("AT-07", "AT-08", "AT-09")
def test_the_window() -> None:
    wire = Wire()
    app = window(wire.driver())

    async def story() -> None:
        async with piloted(app) as pilot:
            assert lines(app)[0] == "CAN Spy - Version 1.0"
            wire.put(Frame(0x48, b"a"))
            await pilot.pause()
            assert lines(app)[-2:] == ["TRACE IS ON", "00001001000 - 61 | a"]
            await pilot.press("f10", "right", "enter")  # Control/Trace
            await pilot.pause()
            assert (lines(app)[-1], status(app)) == ("TRACE IS OFF", "trace off")
            await pilot.press("ctrl+t")
            assert status(app) == "trace on"
            await pilot.press("f10", "right", "down", "enter")  # Control/Clear
            await pilot.pause()
            assert lines(app) == []

    asyncio.run(story())
    app.end()


@pytest.mark.conforms("AT-10")
@pytest.mark.finding("acan A11")
def test_the_window_keeps_what_the_trace_keeps() -> None:
    app = window(Wire().driver())

    async def story() -> None:
        async with piloted(app) as pilot:
            await pilot.pause()
            app.spy.trace.take(Frame(number) for number in range(1500))
            await pilot.pause()
            lines = list(app.query_one("#trace").lines)
            assert lines == app.spy.trace.lines
            assert len([line for line in lines if " - " in line]) == 800

    asyncio.run(story())


def test_send_in_the_window() -> None:
    wire = Wire()
    app = window(wire.driver(), messages=("00000000001 -", "00000000010 -"))

    async def story() -> None:
        async with piloted(app) as pilot:
            assert wire.frames == [Frame(1), Frame(2)]
            await pilot.press("ctrl+s")
            await pilot.pause()
            field = app.screen.query_one("#field0")
            assert field.value == "00000000010 -"
            field.value = "hello"
            await pilot.press("enter")
            assert "like 00001001000 - 61 62" in str(app.screen.query_one("#why").content)
            await pilot.press("tab", "down", "enter")  # the older one of the last two
            await pilot.pause()
            assert field.value == "00000000001 -"
            await pilot.press("enter")
            await pilot.pause()
            assert len(app.screen_stack) == 1
            assert wire.frames[2:] == [Frame(1)]
            assert lines(app)[-1:] == ["Sent: 00000000001 -"]

    asyncio.run(story())
    app.end()


@pytest.mark.conforms("AT-09")
def test_redirect_in_the_window(tmp_path: Path) -> None:
    wire = Wire()
    app = window(wire.driver())
    file = tmp_path / "trace.txt"

    async def story() -> None:
        async with piloted(app) as pilot:
            await pilot.press("f10", "enter")  # File/Redirect to...
            await pilot.pause()
            app.screen.query_one("#field0").value = str(tmp_path)
            await pilot.press("enter")
            assert "directory" in str(app.screen.query_one("#why").content)
            app.screen.query_one("#field0").value = str(file)
            await pilot.press("enter")
            await pilot.pause()
            assert status(app) == f"trace on, into {file}"
            wire.put(Frame(0x48, b"a"))
            await pilot.pause()
            assert [line[11:] for line in file.read_text().splitlines()] == ["00001001000 - 61 | a"]

    asyncio.run(story())
    app.end()


@pytest.mark.parametrize("error", [HubLost("the hub is gone"), None])
def test_what_ends_the_window(error: HubLost | None) -> None:
    driver = Wire().driver()
    if error is None:
        driver.holder = "another spy"
    app = window(driver)

    async def story() -> None:
        async with piloted(app) as pilot:
            driver.failure = error
            app.guarded(app.check)
            await pilot.pause()

    asyncio.run(story())
    app.end()
    assert isinstance(app.failure, HubLost if error else InUse)


# the program


@pytest.mark.conforms("AT-07", "AT-08", "AT-10")
def test_on_a_terminal(open_screen: OpenScreen, tmp_path: Path) -> None:
    """Machine 2 sends to machine 1 what comes to it."""
    file = tmp_path / "trace.txt"
    screen = open_screen(*ON_DOUBLE, "spy", "/R:125", "--redirect", str(file))
    text = screen.wait("TRACE IS ON")
    assert "Hardware was not initialized\n\nClock: 16000 KHz, Rate: 125 Kbps\nTSEG1 = 11," in text
    screen.type(b"\x13")  # Ctrl-S
    screen.wait("Escape: cancel")
    screen.type(b"00001001010 - | ab")
    screen.wait("00001001010 - | ab")
    screen.type(b"\r")
    assert "Sent: 00001001010 - 61 62 | ab" in screen.wait("00001001001 - 61 62 | ab")
    screen.type(b"\x14")
    screen.wait("TRACE IS OFF")
    screen.type(b"\x03")
    assert screen.end() == 0
    assert "- 00001001001 - 61 62 | ab\n" in file.read_text()


@pytest.mark.conforms("AT-07", "AT-08", "AT-10")
def test_without_a_terminal_there_are_plain_lines() -> None:
    command = [sys.executable, *ON_DOUBLE, "spy", "-n", "2", "--send", "00001001010 - | ab", "--send",
               "00001001010 - 63"]  # fmt: skip
    done = warm.run(command, env=environment(), capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[:13] == banner((1, 0), acan.HardConfig(), before=False)
    assert [re.sub(r"^\d\d:\d\d:\d\d - ", "", line) for line in lines[13:]] == [
        "Hardware is initialized",
        "TRACE IS ON",
        "Sent: 00001001010 - 61 62 | ab",
        "Sent: 00001001010 - 63 | c",
        "00001001001 - 61 62 | ab",
        "00001001001 - 63 | c",
    ]
    assert all(re.match(r"\d\d:\d\d:\d\d - ", line) for line in lines[13:])


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["1"], "'1': CANSPY takes no words but /C: and /R:"),
        (["-n", "0"], "-n 0: 1 or more"),
        (["/C:fast"], "/C:fast: decimal digits"),
        (["/I"], "/I: there are /C:..., /R:..."),
    ],
)
def test_mistakes(words: list[str], why: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["acan", "spy", *words]) == 2
    assert capsys.readouterr().err == f"canwire: {why}\n"


# on a bus


def begun(spy: Any) -> None:
    """Its banner is over."""
    for line in spy.stdout:
        if line.endswith("TRACE IS ON\n"):
            return
    raise AssertionError(spy.stderr.read())


@pytest.mark.conforms("AT-07", "AT-08")
def test_it_shows_what_canterm_sends(bench: Bench) -> None:
    """The manual's trace."""
    spy = bench.start("spy", TWO, "-n", "10")
    begun(spy)
    term = bench.screen("term", ONE, "1", "0")
    term.wait("Ctrl-C ends")
    term.type(b"a")
    assert spy.stdout.readline()[11:] == "00001001000 - 61 | a\n"
    for keys, count in (
        (b"b", 1),
        (b"c", 1),
        (b"\x15", 2),
        (b"h", 1),
        (b"e", 1),
        (b"l", 1),
        (b"l", 1),
        (b"o", 1),
    ):
        term.type(keys)
        for _ in range(count):
            assert spy.stdout.readline()[11:] in [line[11:] + "\n" for line in MANUALS]
    assert spy.wait(LONG_S) == 0


@pytest.mark.conforms("AT-09", "AT-10")
def test_its_window_on_a_bus(bench: Bench, tmp_path: Path) -> None:
    file = tmp_path / "trace.txt"
    spy = bench.screen("spy", TWO, "--redirect", str(file))
    assert "Hardware was not initialized" in spy.wait("TRACE IS ON")
    term = bench.screen("term", ONE, "/E", "1", "2")
    term.wait("Ctrl-C ends")
    term.type(b"\x15")
    spy.wait("00001001010 - 38 39 41 42 43 44 45 46 | 89ABCDEF")
    spy.type(b"\x13")
    spy.wait("Escape: cancel")
    spy.type(b"00001001001 - | hello")  # over what is there: it is selected
    spy.wait("00001001001 - | hello")
    spy.type(b"\r")
    spy.wait("Sent: 00001001001 - 68 65 6C 6C 6F | hello")
    term.wait("hello")
    spy.type(b"\x03")
    assert spy.end() == 0
    assert parse_trace_line(file.read_text().splitlines()[-2])[1] == Frame(0x4A, b"89ABCDEF")


@pytest.mark.conforms("AT-11")
def test_a_program_started_later_cannot_install_its_filter(bench: Bench) -> None:
    early = bench.screen("term", ONE, "1", "2")
    early.wait("Ctrl-C ends")
    spy = bench.screen("spy", ONE)
    spy.wait("Hardware was previously initialized")
    spy.wait("TRACE IS ON")
    for program, words in (("term", ["/I", "3", "2"]), ("wct", []), ("spy", ["-n", "1"])):
        status, _, told = bench.run(program, ONE, *words)
        assert status == 2
        assert "canwire acan spy" in told
    assert "cannot install its own message filter" in bench.run("term", ONE, "/I", "3", "2")[2]
    assert bench.run("term", ONE, "3", "2", "-T", "0")[0] == 0  # it leaves the controller as it is
    other = bench.screen("term", TWO, "2", "1")
    other.wait("Ctrl-C ends")
    other.type(b"both hear")
    spy.wait("00001001001 - 62 6F 74 68 20 68 65 61 | both hea")
    early.wait("both hear")
    spy.type(b"\x03")
    assert spy.end() == 0
    assert bench.run("term", ONE, "/I", "1", "2", "-T", "0")[0] == 0
    status, _, told = bench.run("term", ONE, "3", "2", "-T", "0")
    assert "accepts nothing for machine 3" in told  # the filter is what it was


def test_a_hub_that_goes_ends_it(bench: Bench) -> None:
    spy = bench.start("spy", TWO)
    begun(spy)
    bench.end_hub()
    assert spy.wait(LONG_S) == 2
    assert spy.stderr.read().startswith("canwire: ")
