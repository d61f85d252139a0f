"""The window of `canwire view`: by Textual's pilot in virtual time, and as a person sees it on a pseudo terminal."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Awaitable, Callable, Iterator
from contextlib import ExitStack
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import ChannelMode, Frame, Hub, HubChannel, WantedMode
from canwire.commands import main
from canwire.commands.can_line import bring_up
from canwire.commands.live.decoding import decoder
from canwire.commands.live.listening import Listening, places_of
from canwire.commands.shared_hub import find_line
from canwire.commands.view.table import Table
from canwire.commands.view.verb import Plain
from tests import warm
from tests.commands.acan.screen import Screen
from tests.commands.idle import piloted

textual = pytest.importorskip("textual")

CAR = str(Path(__file__).parents[1] / "car.dbc")
LONG_S = 60


class Bench:
    """A hub in virtual time, listened to on HW000001:0, and a sender."""

    def __init__(self, hub: Hub, closing: ExitStack) -> None:
        self.hub = hub
        self.listening = closing.enter_context(Listening(hub, places_of(hub, ["can0"]), WantedMode()))
        self.sender = sender_on(hub, closing)

    def send(self, *frames: Frame) -> None:
        for frame in frames:
            self.sender.send(frame)
            self.hub.run_for(0.01)

    def screen(self, tmp_path: Path, database: bool = False) -> Any:
        from canwire.commands.view.screen import ViewScreen

        decode = decoder(CAR) if database else None
        return ViewScreen(
            self.listening, Table(), decode, folder=tmp_path, clock=lambda: datetime(2026, 11, 22, 12, 30)
        )


def sender_on(hub: Hub, closing: ExitStack) -> HubChannel:
    place = find_line(hub, "HW000001:1")
    channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
    channel.set_up(ChannelMode(receive=1, transmit=64))
    bring_up(hub, place, WantedMode())
    channel.activate()
    return channel


@pytest.fixture
def bench() -> Iterator[Bench]:
    with canwire.connect(time="virtual") as hub, ExitStack() as closing:
        yield Bench(hub, closing)


def driven(app: Any, steps: Callable[[Any], Awaitable[None]]) -> None:
    async def run() -> None:
        async with piloted(app, size=(120, 20)) as pilot:
            await steps(pilot)

    asyncio.run(asyncio.wait_for(run(), LONG_S))


def shown(app: Any, id: str = "rows") -> list[str]:
    """The lines of a widget, as they stand in the window."""
    widget = app.query_one(f"#{id}")
    if id == "rows":
        lines = [widget.render_line(y).text.rstrip() for y in range(widget.size.height)]
    else:
        lines = str(widget.render()).splitlines()
    return [line.rstrip() for line in lines if line.strip()]


@pytest.mark.smoke
@pytest.mark.conforms("PC-13")
def test_rows_come_and_change(bench: Bench, tmp_path: Path) -> None:
    app = bench.screen(tmp_path)
    bench.send(Frame(0x123, b"\x11\x22"), Frame(0x7FF, extended=True), Frame(0x123, b"\x11\x23"))

    async def steps(pilot: Any) -> None:
        assert [line.split()[:4] for line in shown(app)] == [
            ["can0", "123", "2", "11"],
            ["can0", "000007FF", "0", "1"],
        ]
        assert shown(app)[0].split()[2:] == ["2", "11", "23", "2", "20.0", "20.0", "20.0"]
        styles = {part.text: part.style for part in app.query_one("#rows").render_line(0) if part.style}
        assert styles["23"].bgcolor.name == "yellow"
        assert not any(
            text.startswith("11") and style.bgcolor == styles["23"].bgcolor for text, style in styles.items()
        )
        bench.send(Frame(0x001))
        app.look()
        assert [line.split()[1] for line in shown(app)] == ["001", "123", "000007FF"]
        assert "3 of 3 identifiers  4 frames  0 errors" in shown(app, "status")[0]

    driven(app, steps)


@pytest.mark.conforms("PC-13")
def test_pause_filter_clear(bench: Bench, tmp_path: Path) -> None:
    app = bench.screen(tmp_path)
    bench.send(Frame(0x123), Frame(0x200))

    async def steps(pilot: Any) -> None:
        await pilot.press("space")
        before = shown(app)
        bench.send(Frame(0x123), Frame(0x300))
        app.look()
        assert shown(app) == before
        assert "PAUSED" in shown(app, "status")[0]
        await pilot.press("space")
        assert [line.split()[1] for line in shown(app)] == ["123", "200", "300"]
        assert "4 frames" in shown(app, "status")[0]
        await pilot.press("slash", "~", "2", "0", "0")
        assert [line.split()[1] for line in shown(app)] == ["123", "300"]
        assert "2 of 3 identifiers" in shown(app, "status")[0]
        await pilot.press("s")  # a letter of the filter while one types there
        assert not list(tmp_path.iterdir())
        await pilot.press("backspace", "enter", "c")
        assert shown(app) == []

    driven(app, steps)


@pytest.mark.conforms("PC-13")
def test_signals_and_saving(bench: Bench, tmp_path: Path) -> None:
    app = bench.screen(tmp_path, database=True)
    bench.send(Frame(0x001), Frame(0x100, bytes.fromhex("401F0A00")))

    async def steps(pilot: Any) -> None:
        assert shown(app, "signals") == ["not in the database"]
        await pilot.press("down", "down")
        await pilot.pause()
        assert shown(app, "signals") == ["Engine", "  Speed: 2000 rpm", "  Torque: 10 Nm"]
        await pilot.press("s")
        assert "saved 2 rows to" in shown(app, "status")[0]
        await pilot.press("up")
        await pilot.pause()
        assert shown(app, "signals") == ["not in the database"]

    driven(app, steps)
    saved = (tmp_path / "canwire-view-20261122-123000.csv").read_text().splitlines()
    assert saved[0] == "line,id,len,data,count,period ms,min,max,decoded"
    assert saved[2] == 'can0,100,4,40 1F 0A 00,1,,,,"Engine(Speed: 2000 rpm, Torque: 10 Nm)"'


def test_a_folder_that_cannot_be_written(bench: Bench, tmp_path: Path) -> None:
    app = bench.screen(tmp_path / "nowhere")

    async def steps(pilot: Any) -> None:
        await pilot.press("s")
        assert "not saved: [Errno 2]" in shown(app, "status")[0]

    driven(app, steps)


def test_more_rows_than_the_window_has(bench: Bench, tmp_path: Path) -> None:
    app = bench.screen(tmp_path)
    bench.send(*(Frame(id) for id in range(60)))

    async def steps(pilot: Any) -> None:
        await pilot.press("end")
        await pilot.pause()
        assert shown(app)[-1].split()[1] == "03B"
        await pilot.press("home")
        await pilot.pause()
        assert shown(app)[0].split()[1] == "000"

    driven(app, steps)


def test_a_board_that_is_pulled_out_ends_it(bench: Bench, tmp_path: Path) -> None:
    app = bench.screen(tmp_path)

    async def steps(pilot: Any) -> None:
        bench.hub.unplug("HW000001")
        app.look()
        await pilot.pause()

    driven(app, steps)
    assert isinstance(app.failure, canwire.Unplugged)
    assert app.return_code == 2


def test_plain_lines(bench: Bench, capsys: pytest.CaptureFixture[str]) -> None:
    bench.send(Frame(0x123, b"\x11"), Frame(0x123, b"\x12"), Frame(0x7FF))
    table = Table()
    Plain(bench.hub, bench.listening, table, None).run(0.5, 1.0)
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[:4] for line in lines] == [["can0", "123", "1", "2"], ["can0", "7FF", "0", "1"]]


def test_the_verb_without_a_terminal(hub_address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["view", "can0", "--seconds", "0.05", "--hub", hub_address]) == 0
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.endswith("canwire: 0 frames of 0 identifiers, 0 errors, 0 lost\n")


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--interval", "0"), "--interval 0.0"),
        (("--seconds", "-1"), "--seconds -1.0"),
        (("--db", "x.dbc"), "x.dbc"),
    ],
)
def test_mistakes(
    hub_address: str, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], why: str
) -> None:
    assert main(["view", "can0", *words, "--hub", hub_address]) == 2
    assert why in capsys.readouterr().err


@pytest.mark.conforms("PC-13")
@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo terminals")
def test_on_a_terminal(hub_address: str, tmp_path: Path) -> None:
    screen = Screen(["-m", "canwire", "view", "can0", "--hub", hub_address], str(tmp_path))
    try:
        screen.wait("0 of 0 identifiers")
        warm.run(
            [sys.executable, "-m", "canwire", "send", "HW000002:0", "123#DEADBEEF", "--hub", hub_address],
            check=True, timeout=LONG_S,
        )  # fmt: skip
        screen.wait("DE AD BE EF")
        screen.type(b"/")
        screen.wait("typing a filter")
        screen.type(b"~123")
        screen.wait("0 of 1 identifiers")
        screen.type(b"\x03")
        assert screen.end() == 0
    finally:
        screen.close()
