"""`canwire load`: its figures, bars, and what it prints where."""

from __future__ import annotations

import json
from contextlib import ExitStack
from dataclasses import replace
from itertools import islice, repeat

import pytest

import canwire
from canwire import Frame, LinePlace, LineStatus, every_line, lines_now
from canwire.commands import main
from canwire.commands.gen.sending import Generator
from canwire.commands.live.bars import format_bar, format_reading, format_total
from canwire.commands.live.load import Bars, Watch
from canwire.commands.live.meter import Meter, Reading
from tests.cases import each
from tests.commands.conftest import running_lines

SECOND = 1_000_000_000
READING = Reading("can0", 40.04, 62.1, 38.7, 1748.0, 0.5, 5250, 3, "500000 bit/s")


@pytest.fixture
def idle() -> list[tuple[LinePlace, LineStatus]]:
    """All CAN lines of the usual boards, which are on one bus, and how they are."""
    with canwire.connect(time="virtual") as hub:
        return lines_now(hub, every_line(hub, "CAN"))


@pytest.mark.conforms("PC-08")
def test_figures(idle: list[tuple[LinePlace, LineStatus]]) -> None:
    meter = Meter()

    def look(time_ns: int, load: float, **first: int) -> Reading:
        others = [(place, replace(status, time_ns=time_ns, load=load)) for place, status in idle]
        (reading,) = meter.look([(others[0][0], replace(others[0][1], **first)), *others[1:]])
        return reading

    began = look(SECOND, 90.0, frames_sent=1000, errors=7)
    assert (began.load, began.peak, began.mean, began.frames_s, began.frames) == (90.0, 0.0, 0.0, 0.0, 0)
    one = look(3 * SECOND, 30.0, frames_sent=1100, frames_received=50, errors=9)
    assert (one.load, one.peak, one.mean, one.frames_s, one.errors_s) == (30.0, 30.0, 30.0, 75.0, 1.0)
    two = look(4 * SECOND, 10.0, frames_sent=5)  # set up anew: counted from nothing
    assert (two.load, two.peak, two.mean, two.frames_s, two.errors_s) == (10.0, 30.0, 20.0, 5.0, 0.0)
    assert (two.frames, two.errors, two.rates) == (155, 2, "nobody is there")


def test_a_line_of_words() -> None:
    assert format_reading(READING, 6) == (
        "can0    40.0 %  peak  62.1 %  mean  38.7 %   1748.0 frames/s    0.5 errors/s  500000 bit/s"
    )
    assert format_total(READING) == "can0: mean 38.7 %, peak 62.1 %, 5250 frames, 3 errors"


def test_a_bar_has_the_share_and_the_peak() -> None:
    shown = format_bar(READING, 4, 4 + len(format_reading(READING, 4)) + 60, coloured=False)
    bar = shown[shown.index("[") + 1 : shown.index("]")]
    assert bar.count("#") == round(0.4004 * len(bar))
    assert bar.index("|") == round(0.621 * len(bar))
    assert set(bar) == {"#", "-", "|"}
    assert "\x1b[32m" in format_bar(READING, 4, 200, coloured=True)
    assert "\x1b[31m" in format_bar(READING._replace(load=95.0), 4, 200, coloured=True)


@each("columns", [20, 60, 100, 110, 200])
@each("load", [0.0, 50.0, 100.0])
def test_a_bar_never_breaks_the_line(columns: int, load: float) -> None:
    shown = format_bar(READING._replace(load=load, peak=load), 8, columns, coloured=False)
    assert len(shown) < columns


def test_bars_are_drawn_in_place(capsys: pytest.CaptureFixture[str]) -> None:
    bars = Bars()
    bars([READING, READING._replace(bus="body")])
    first = capsys.readouterr().out
    bars([READING, READING._replace(bus="body")])
    assert capsys.readouterr().out == "\x1b[2A" + first


def test_a_bus_at_work() -> None:
    with canwire.connect(time="virtual") as hub, ExitStack() as closing:
        channels = running_lines(hub, closing, "HW000001:0", "HW000001:1", transmit=2048)
        for _ in range(1000):
            channels[0][1].send(Frame(0x555, b"\x55" * 8))
        seen: list[Reading] = []
        watch = Watch(hub, every_line(hub, "CAN"))
        watch.run(seen.extend, 0.1, None, 0.5)
        generator = Generator(hub, *channels[1], 1.0)
        assert generator.run(islice(repeat((0.0, Frame(1))), 5), None) == 0
    assert [reading.bus for reading in seen] == ["can0"] * 5
    assert sum(reading.frames_s * 0.1 for reading in seen) == pytest.approx(1000, abs=1)
    assert watch.last[0].frames == 1000
    assert watch.last[0].rates == "500000 bit/s, 2000000 after BRS"
    assert seen[0].load > 90


@pytest.mark.conforms("PC-11")
def test_the_verb(hub_address: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["load", "can0", "-n", "2", "--interval", "0.05", "--hub", hub_address]
    assert main(words) == 0
    told = capsys.readouterr()
    assert [line.split()[0] for line in told.out.splitlines()] == ["can0", "can0"]
    assert told.err == "canwire: can0: mean 0.0 %, peak 0.0 %, 0 frames, 0 errors\n"
    assert main([*words, "-n", "1", "--json"]) == 0
    objects = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [(one["bus"], one["load"]) for one in objects] == [("can0", 0.0)]


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("-n", "0"), "-n 0: 1 or more"),
        (("--interval", "0"), "--interval 0.0: 0.05 seconds or more"),
        (("--seconds", "-1"), "--seconds -1.0: 0 or more"),
        (("cna0",), "did you mean can0?"),
    ],
)
def test_mistakes(
    hub_address: str, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], why: str
) -> None:
    assert main(["load", *words, "--hub", hub_address]) == 2
    assert why in capsys.readouterr().err
