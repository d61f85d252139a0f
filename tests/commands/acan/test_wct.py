"""`canwire acan wct`: WCT.INI, settings that take effect at once, and its window."""

from __future__ import annotations

import asyncio
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadConfig, BadTiming, BadValue, Frame, HubLost, InUse
from canwire.commands import main
from canwire.commands.acan import programs as acan_programs
from canwire.commands.acan.machines import config_of, set_up
from canwire.commands.acan.term import PATTERN, SEQUENCE, Terminal
from canwire.commands.acan.wct import Settings, Wct, overridden, read_settings, write_settings
from canwire.commands.acan.words import parsed
from tests import warm
from tests.commands.acan.double import Wire
from tests.commands.acan.screen import ON_DOUBLE, OpenScreen, environment
from tests.commands.idle import piloted

MANUALS = "[WCT]\r\nClock=16000\r\nRate=125\r\nLocal=3\r\nTarget=5\r\nEcho=1\r\nLoop=0\r\n"

# WCT.INI


@pytest.mark.conforms("AT-06")
def test_the_manuals_file(tmp_path: Path) -> None:
    path = tmp_path / "WCT.INI"
    path.write_bytes(MANUALS.encode())
    assert read_settings(path) == Settings(16_000, 125, 3, 5, 1, 0)
    write_settings(path, read_settings(path))
    assert path.read_bytes().decode().rstrip() == MANUALS.rstrip()


@pytest.mark.conforms("AT-06")
def test_without_a_file_everything_is_as_usual(tmp_path: Path) -> None:
    assert read_settings(tmp_path / "WCT.INI") == Settings(16_000, 250, 1, 0, 0, 0)


@pytest.mark.conforms("AT-06")
def test_words_override_the_file() -> None:
    settings = Settings(16_000, 125, 3, 5, 1, 0)
    assert overridden(settings, parsed(["/R:500"], "CR")) == replace(settings, rate=500)
    assert overridden(settings, parsed(["/c:8000"], "CR")) == replace(settings, clock=8000)
    with pytest.raises(BadValue, match="Rate=0: 1 to 65535"):
        overridden(settings, parsed(["/R:0"], "CR"))


@pytest.mark.conforms("AT-06")
@pytest.mark.parametrize(
    ("entry", "why"),
    [
        ("Local=0", "Local=0: 1 to 7, this machine"),
        ("Local=8", "Local=8: 1 to 7"),
        ("Target=8", "Target=8: 0 to 7"),
        ("Echo=2", "Echo=2: 0 to 1"),
        ("Loop=yes", "Loop=yes: a decimal number"),
        ("Rate=-1", "Rate=-1: a decimal number"),
        ("Clock=²", "Clock=²: a decimal number"),
        ("nonsense", "nonsense"),
        pytest.param("Local=", "Local=: a decimal number", marks=pytest.mark.finding("acan A12")),
    ],
)
def test_entries_that_cannot_be(tmp_path: Path, entry: str, why: str) -> None:
    path = tmp_path / "WCT.INI"
    path.write_text(f"[wct]\n{entry}\n", encoding="utf-8")
    with pytest.raises(BadConfig, match=f"^{re.escape(str(path))}: .*{why}"):
        read_settings(path)


@pytest.mark.finding("acan A9")
def test_a_file_in_the_windows_code_page_keeps_its_bytes(tmp_path: Path) -> None:
    path = tmp_path / "WCT.INI"
    path.write_bytes(b"; f\xfcr B\x81\r\n[Window]\r\ntitle=M\xfcller\x81\r\n[wct]\r\nLocal=2\r\n")
    write_settings(path, replace(read_settings(path), target=4))
    assert read_settings(path) == Settings(local=2, target=4)
    assert b"title=M\xfcller\x81\r\n" in path.read_bytes()


def test_other_sections_and_entries_stay(tmp_path: Path) -> None:
    path = tmp_path / "WCT.INI"
    path.write_text("[Window]\nleft=3\n[wct]\nLOCAL = 2\nfont=big\n", encoding="utf-8")
    write_settings(path, replace(read_settings(path), target=4))
    assert read_settings(path) == Settings(local=2, target=4)
    text = path.read_text(encoding="utf-8")
    assert "left=3" in text
    assert "font=big" in text
    assert text.upper().count("[WCT]") == 1


SETTINGS = st.builds(
    Settings,
    *[st.integers(1, 65_535)] * 2,
    st.integers(1, 7),
    st.integers(0, 7),
    st.integers(0, 1),
    st.integers(0, 1),
)


@given(SETTINGS)
def test_round_trip(tmp_path_factory: pytest.TempPathFactory, settings: Settings) -> None:
    path = tmp_path_factory.getbasetemp() / "WCT.INI"
    write_settings(path, settings)
    assert read_settings(path) == settings


# settings at work


def peer(wire: Any, local: int, remote: int = 1) -> Terminal:
    driver = wire.driver()
    set_up(driver, local)
    terminal = Terminal(driver, local, remote)
    terminal.open()
    return terminal


@pytest.mark.conforms("AT-06")
def test_it_always_initialises() -> None:
    driver = Wire().driver(config_of(3, 16_000, 125), on_bus=True)
    Wct(driver, Settings(local=2, rate=500)).start()
    assert driver.config() == config_of(2, 16_000, 500)
    assert driver.done == ["configure", "on"]


@pytest.mark.conforms("AT-06")
def test_it_talks_like_canterm() -> None:
    wire = Wire()
    two = peer(wire, 2)
    wct = Wct(wire.driver(), Settings(local=1, target=2, echo=1))
    wct.start()
    assert wct.terminal.typed(b"hi\x15") == b"hi" + SEQUENCE
    assert two.received() == b"hi" + SEQUENCE
    two.typed(b"back")
    assert wct.terminal.received() == b"back"
    wct.stop()
    two.typed(b"more")
    assert wct.terminal.received() == b""


@pytest.mark.conforms("AT-06")
def test_changes_take_effect_at_once() -> None:
    wire = Wire()
    two, three = peer(wire, 2), peer(wire, 3, 4)
    driver = wire.driver()
    wct = Wct(driver, Settings(local=1, target=2))
    wct.start()
    driver.done.clear()
    wct.apply(replace(wct.settings, target=3, echo=1))
    assert driver.done == []  # nothing of this is the controller's
    assert wct.terminal.typed(b"a") == b"a"
    assert (two.received(), three.received()) == (b"", b"a")
    wct.apply(replace(wct.settings, local=4, rate=125, loop=1))
    assert driver.done == ["configure", "on"]
    assert driver.config() == config_of(4, 16_000, 125)
    three.typed(b"b")
    assert wct.terminal.received() == b"b"
    assert three.received() == b"b"


@pytest.mark.conforms("AT-06")
def test_what_cannot_be_changes_nothing() -> None:
    wire = Wire()
    two = peer(wire, 2)
    driver = wire.driver()
    wct = Wct(driver, Settings(local=1, target=2))
    wct.start()
    with pytest.raises(BadTiming):
        wct.apply(replace(wct.settings, rate=1, local=3))
    assert wct.settings == Settings(local=1, target=2)
    assert (driver.config(), driver.on_bus) == (config_of(1), True)
    two.typed(b"still here")
    assert wct.terminal.received() == b"still here"
    driver.holder = "canwire acan spy"
    with pytest.raises(InUse):
        wct.apply(replace(wct.settings, rate=125))
    two.typed(b"and now")
    assert wct.terminal.received() == b"and now"


@pytest.mark.conforms("AT-11")
def test_a_spy_does_not_let_it_start() -> None:
    driver = Wire().driver(config_of(1), on_bus=True)
    driver.holder = "canwire acan spy"
    with pytest.raises(InUse, match="cannot install its own message filter"):
        Wct(driver, Settings()).start()


# the window


def window(driver: Any, settings: Settings, path: Path) -> Any:
    screens = pytest.importorskip("canwire.commands.acan.wct_screen")
    return screens.WctScreen(driver, settings, path)


def shown(app: Any) -> str:
    return "\n".join(app.screen_stack[0].query_one("#characters").lines)


def status(app: Any) -> str:
    return str(app.screen_stack[0].query_one("#status").content)


@pytest.mark.conforms("AT-06")
def test_keys_go_out_and_what_comes_is_shown(tmp_path: Path) -> None:
    wire = Wire()
    two = peer(wire, 2)
    app = window(wire.driver(), Settings(local=1, target=2), tmp_path / "WCT.INI")

    async def story() -> None:
        async with piloted(app) as pilot:
            await pilot.press("h", "i", "space", "enter", "ctrl+u")
            assert two.received() == b"hi \r" + SEQUENCE
            await pilot.press("ctrl+t")
            assert two.received() == PATTERN
            two.typed(b"first\r\nsec")
            two.typed(b"ond")
            await pilot.pause()
            assert shown(app) == "first\nsecond"
            assert status(app) == "machine 1 to machine 2, 250 kbit/s"

    asyncio.run(story())


@pytest.mark.conforms("AT-06")
def test_options_can(tmp_path: Path) -> None:
    wire = Wire()
    three = peer(wire, 3)
    driver = wire.driver()
    path = tmp_path / "WCT.INI"
    app = window(driver, Settings(local=1, target=2), path)

    async def story() -> None:
        async with piloted(app) as pilot:
            await pilot.press("f10", "right", "enter")
            await pilot.pause()
            fields = list(app.screen.query("Input"))
            assert [field.value for field in fields] == ["16000", "250", "1", "2", "0", "0"]
            fields[2].value = "0"
            fields[2].focus()
            await pilot.press("enter")
            assert str(app.screen.query_one("#why").content) == "Local=0: 1 to 7, this machine"
            fields[2].value = ""
            await pilot.press("enter")
            assert str(app.screen.query_one("#why").content) == "Local=: a decimal number"
            for number, value in ((1, "125"), (2, "6"), (3, "3"), (4, "1")):
                fields[number].value = value
            await pilot.press("enter")
            await pilot.pause()
            assert len(app.screen_stack) == 1
            assert driver.config() == config_of(6, 16_000, 125)
            assert status(app) == "machine 6 to machine 3, 125 kbit/s, echo"
            await pilot.press("x")
            assert (shown(app), three.received()) == ("x", b"x")
        assert read_settings(path) == Settings(16_000, 125, 6, 3, 1, 0)

    asyncio.run(story())


@pytest.mark.conforms("AT-06")
@pytest.mark.parametrize("keys", [("f10", "enter"), ("ctrl+c",), ("ctrl+q",)])
def test_file_quit(tmp_path: Path, keys: tuple[str, ...]) -> None:
    driver = Wire().driver()
    app = window(driver, Settings(), tmp_path / "WCT.INI")

    async def story() -> None:
        async with piloted(app) as pilot:
            await pilot.press(*keys)
            await pilot.pause()
            assert not app.is_running or app._exit

    asyncio.run(story())
    app.end()
    assert driver.blocks == []


def test_what_ends_a_window(tmp_path: Path) -> None:
    driver = Wire().driver()
    driver.holder = "canwire acan spy"
    app = window(driver, Settings(), tmp_path / "WCT.INI")

    async def story() -> None:
        async with piloted(app) as pilot:
            await pilot.pause()

    asyncio.run(story())
    assert isinstance(app.failure, InUse)
    assert app.return_code == 2


def test_a_lost_hub_ends_a_window(tmp_path: Path) -> None:
    wire = Wire()
    driver = wire.driver()
    app = window(driver, Settings(), tmp_path / "WCT.INI")

    async def story() -> None:
        async with piloted(app) as pilot:
            driver.failure = HubLost("the hub is gone")
            app.guarded(app.check)
            await pilot.pause()

    asyncio.run(story())
    assert isinstance(app.failure, HubLost)


def test_bus_errors_stand_in_the_last_line(tmp_path: Path) -> None:
    from canwire import acan

    driver = Wire().driver()
    app = window(driver, Settings(), tmp_path / "WCT.INI")

    async def story() -> None:
        async with piloted(app) as pilot:
            driver.happen(acan.Condition.BUSERR, ecc=0xD9)
            await pilot.pause()
            assert status(app) == "bus error at the acknowledge slot, sending: nobody acknowledges"

    asyncio.run(story())


def test_remote_frames_are_nothing_to_show() -> None:
    wire = Wire()
    wct = Wct(wire.driver(), Settings(local=1))
    wct.start()
    wire.put(Frame(0x49, remote=True))
    assert wct.terminal.received() == b""


# the program


@pytest.mark.conforms("AT-06")
def test_on_a_terminal(open_screen: OpenScreen, tmp_path: Path) -> None:
    """Machine 2 sends everything back."""
    path = tmp_path / "WCT.INI"
    path.write_text("[WCT]\nRate=125\nLocal=1\nTarget=3\n")
    screen = open_screen(*ON_DOUBLE, "wct", "/R:500", "--ini", str(path))
    screen.wait("machine 1 to machine 3, 500 kbit/s")
    screen.type(b"\x1b[21~")  # F10
    screen.wait("Quit")
    screen.type(b"\x1b[C")  # right
    screen.wait("CAN...")
    screen.type(b"\r")
    for hint in ("Clock: 1 to 65535, kHz.", "Rate: 1 to 65535, kbit/s.", "Local: 1 to 7, this machine."):
        screen.wait(hint)
        screen.type(b"\t")
    screen.wait("Target: 0 to 7, 0 for all machines.")
    screen.type(b"2")  # over what is there: it is selected
    screen.wait("Target      2")
    screen.type(b"\r")
    screen.wait("machine 1 to machine 2, 500 kbit/s")
    screen.type(b"hello\x15")
    screen.wait("hello0123456789ABCDEF")
    screen.type(b"\x1b[21~")
    screen.wait("Quit")
    screen.type(b"\r")
    assert screen.end() == 0
    assert read_settings(path) == Settings(rate=500, local=1, target=2)


@pytest.mark.conforms("AT-06")
def test_without_a_terminal_bytes_are_copied(tmp_path: Path) -> None:
    path = tmp_path / "WCT.INI"
    write_settings(path, Settings(local=1, target=2))
    command = [sys.executable, *ON_DOUBLE, "wct", "-T", "0", "--ini", str(path)]
    done = warm.run(command, env=environment(), input=b"\x15 as it is", capture_output=True, timeout=60)
    assert (done.returncode, done.stdout) == (0, b"\x15 as it is")
    assert done.stderr == b"canwire: WCT: machine 1 to machine 2\n"


@pytest.mark.parametrize("program", ["wct", "spy"])
def test_windows_need_textual(
    program: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(acan_programs, "_is_screen", lambda: True)
    monkeypatch.setattr(acan_programs, "find_spec", lambda name: None)
    assert main(["acan", program]) == 2
    assert capsys.readouterr().err == (
        "canwire: textual is not installed; run: pip install 'canwire[tools]'\n"
    )


@pytest.mark.conforms("AT-06")
def test_mistakes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "WCT.INI"
    path.write_text("[WCT]\nLocal=0\n")
    assert main(["acan", "wct", "--ini", str(path)]) == 2
    assert capsys.readouterr().err == (f"canwire: {path}: [WCT] Local=0: 1 to 7, this machine\n")
    assert main(["acan", "wct", "1", "2"]) == 2
    assert "'1': machine numbers are in WCT.INI" in capsys.readouterr().err
