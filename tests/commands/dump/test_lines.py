"""What `canwire dump` shows of a frame, and which frames: stamps, filters, JSON."""

from __future__ import annotations

import io
import json
import time
from argparse import Namespace
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import canwire
from canwire import (
    BadValue,
    BusEvent,
    ErrorKind,
    ErrorState,
    EventKind,
    Frame,
    LogLine,
    WantedMode,
    load_database,
)
from canwire.commands import main
from canwire.commands.can_line import bring_up
from canwire.commands.databases.chosen import Databases
from canwire.commands.dump.as_json import format_json
from canwire.commands.dump.filters import Capture, Masked, parse_capture
from canwire.commands.dump.output import Lines
from canwire.commands.dump.printing import JSON, LOG, SCREEN, Extras, Printer
from canwire.commands.dump.stamps import Stamps
from canwire.commands.dump.verb import Dump
from canwire.commands.dump.words import in_words
from canwire.commands.live.decoding import decoder
from canwire.commands.live.listening import RECORD, Listening, Record, places_of
from canwire.commands.shared_hub import find_line
from tests.cases import each

CAR = str(Path(__file__).parents[1] / "car.dbc")
SECOND = 1_000_000_000


@each(
    ("kind", "shown"),
    [
        ("a", ["(1000000001.500000)", "(1000000001.500250)", "(1000000003.000000)"]),
        ("d", ["(000.000000)", "(000.000250)", "(001.499750)"]),
        ("z", ["(000.000000)", "(000.000250)", "(001.500000)"]),
        ("h", ["(000001.500000000)", "(000001.500250000)", "(000003.000000000)"]),
    ],
)
def test_stamps(kind: str, shown: list[str]) -> None:
    stamps = Stamps(kind, 1_000_000_000 * SECOND)
    assert [stamps.text(at) for at in (1_500_000_000, 1_500_250_000, 3 * SECOND)] == shown


def test_a_date(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TZ", "UTC")
    time.tzset()
    assert Stamps("A", 0).text(86_400 * SECOND + 1_000) == "(1970-01-02 00:00:00.000001)"
    monkeypatch.undo()
    time.tzset()


def shown_by(capture: Capture, *frames: Frame) -> set[int]:
    return {frame.id for frame in frames if capture.accepts(frame)}


@pytest.mark.conforms("PC-03", "PL-21")
@each(
    ("text", "shown"),
    [
        (["123:7FF"], {0x123}),
        (["700:700"], {0x7E0, 0x7E8}),
        (["123~7FF"], {0x7E0, 0x7E8, 0x18FF1234}),
        (["123:7FF,7e8:7ff"], {0x123, 0x7E8}),
        (["123:7FF", "7E0:7FF"], {0x123, 0x7E0}),
        (["123~7FF,7E0~7FF,j"], {0x7E8, 0x18FF1234}),
        (["18FF0000:1FFF0000"], {0x18FF1234}),
        (["00000123:1FFFFFFF"], set()),
        (["123"], {0x123}),
        (["~123"], {0x7E0, 0x7E8, 0x18FF1234}),
        (["100-7E0"], {0x123, 0x7E0}),
        (["~100-7E0"], {0x7E8, 0x18FF1234}),
        (["00000000-1FFFFFFF"], {0x18FF1234}),
        ([], {0x123, 0x7E0, 0x7E8, 0x18FF1234}),
    ],
)
def test_filters(text: list[str], shown: set[int]) -> None:
    frames = [Frame(0x123), Frame(0x7E0), Frame(0x7E8), Frame(0x18FF1234, extended=True)]
    capture = parse_capture(text, [], True)
    assert shown_by(capture, *frames) == shown
    assert capture.accepts(BusEvent(EventKind.ERROR))


@each(
    ("kinds", "errors", "shown", "events"),
    [
        ([], False, {1, 2, 3, 4}, set()),
        (["data"], False, {1, 3, 4}, set()),
        (["remote"], True, {2}, {"ERROR", "STATE"}),
        (["fd"], False, {3}, set()),
        (["fd,classic"], False, {1, 2, 3, 4}, set()),
        (["classic", "extended"], False, {4}, set()),
        (["error"], False, set(), {"ERROR"}),
        (["remote", "state"], False, {2}, {"STATE"}),
    ],
)
def test_kinds(kinds: list[str], errors: bool, shown: set[int], events: set[str]) -> None:
    frames = [Frame(1, b"1"), Frame(2, remote=True), Frame(3, b"3", fd=True), Frame(4, extended=True)]
    capture = parse_capture([], kinds, errors)
    assert shown_by(capture, *frames) == shown
    assert {
        kind.name for kind in (EventKind.ERROR, EventKind.STATE) if capture.accepts(BusEvent(kind))
    } == events


@each(
    "text",
    [
        "",
        "x",
        "123:",
        ":7FF",
        "123:7FG",
        "800:7FF",
        "123456789:1",
        "123=7FF",
        "200-100",
        "123-00000200",
        "800",
        "12-",
    ],
)
def test_filters_that_are_none(text: str) -> None:
    with pytest.raises(BadValue, match="--filter"):
        parse_capture([text], [], False)


def test_a_kind_that_is_none() -> None:
    with pytest.raises(BadValue, match="--kind slow: data, remote"):
        parse_capture([], ["slow"], False)


@given(st.integers(0, 0x7FF), st.integers(0, 0x7FF), st.integers(0, 0x7FF))
def test_a_filter_and_its_inverse_share_out_all_frames(code: int, mask: int, id: int) -> None:
    one, other = (parse_capture([f"{code:03X}{sign}{mask:X}"], [], False) for sign in ":~")
    assert one.accepts(Frame(id)) == ((id & mask) == (code & mask)) != other.accepts(Frame(id))
    span, rest = (
        parse_capture([f"{sign}{min(code, mask):03X}-{max(code, mask):03X}"], [], False) for sign in ("", "~")
    )
    assert span.accepts(Frame(id)) == (min(code, mask) <= id <= max(code, mask)) != rest.accepts(Frame(id))


def test_json() -> None:
    frame = Frame(0x18FF1234, b"\x11\x22", extended=True)
    assert json.loads(format_json(LogLine(1_500_000_000, "can0", frame))) == {
        "time_s": 1.5,
        "line": "can0",
        "id": "18FF1234",
        "data": "1122",
        "dlc": 2,
    }
    asked = json.loads(format_json(LogLine(0, "can0", Frame(0x12, remote=True, dlc=4))))
    assert (asked["id"], asked["remote"], asked["dlc"], "data" in asked) == ("012", True, 4, False)
    fast = json.loads(format_json(LogLine(0, "can0", Frame(1, bytes(12), fd=True, bit_rate_switch=True))))
    assert (fast["fd"], fast["bit_rate_switch"], fast["dlc"]) == (True, True, 9)
    error = BusEvent(EventKind.ERROR, error=ErrorKind.STUFF, tec=8)
    told = json.loads(format_json(LogLine(0, "can0", error)))
    assert (told["event"], told["error"], told["tec"], told["state"]) == ("error", "stuff", 8, "error_active")


@pytest.mark.parametrize(
    "words", [["--json", "-l"], ["--json", "-t", "a"], ["-l", "-t", "d"], ["--filter", "x"]]
)
def test_what_does_not_go_together(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dump", "can0", *words]) == 2
    assert capsys.readouterr().err.startswith("canwire: -")


def record_of(content: Frame | BusEvent, time_ns: int = 0, *, sent: bool = False) -> Record:
    """As it comes from a channel's queue; `sent` by the line itself."""
    if isinstance(content, BusEvent):
        return RECORD.unpack(replace(content, timestamp_ns=time_ns).to_record())
    (row,) = canwire.frames_to_array([content])
    found: Record = RECORD.unpack(row.tobytes())
    return time_ns, found[1], found[2] | (canwire.SELF_RECEPTION if sent else 0), found[3]


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    extended = draw(st.booleans())
    id = draw(st.integers(0, 0x1FFFFFFF if extended else 0x7FF))
    kind = draw(st.sampled_from(["classic", "remote", "fd", "long code"]))
    if kind == "remote":
        return Frame(id, extended=extended, remote=True, dlc=draw(st.integers(0, 15)))
    if kind == "fd":
        size = draw(st.sampled_from([0, 1, 7, 8, 12, 64]))
        return Frame(
            id, draw(st.binary(min_size=size, max_size=size)), extended=extended, fd=True,
            bit_rate_switch=draw(st.booleans()), error_state_indicator=draw(st.booleans()),
        )  # fmt: skip
    if kind == "long code":
        return Frame(
            id, draw(st.binary(min_size=8, max_size=8)), extended=extended, dlc=draw(st.integers(9, 15))
        )
    return Frame(id, draw(st.binary(max_size=8)), extended=extended)


@pytest.mark.conforms("PC-01")
@given(st.lists(frames(), max_size=5), st.integers(0, 2 * 10**18))
def test_quick_lines_are_the_formatters_own(content: list[Frame], time_ns: int) -> None:
    records = [record_of(frame, time_ns) for frame in content] * 2  # the second time by what was learnt
    screen = Printer(SCREEN, Capture(), epoch_ns=0).lines("can0", records)
    assert screen == [canwire.format_candump_line(LogLine(0, "can0", frame)) for frame in content] * 2
    log = Printer(LOG, Capture(), epoch_ns=7).lines("can0", records)
    assert log == [canwire.format_log_line(LogLine(time_ns + 7, "can0", frame)) for frame in content] * 2


@given(st.lists(frames(), max_size=3))
def test_candump_s_extras_are_the_formatters_own(content: list[Frame]) -> None:
    """Frames that the line sent itself are TX."""
    records = [record_of(frame, 5, sent=number == 1) for frame in content for number in range(2)] * 2
    extras = Extras(ascii=True, messages=True, raw_dlc=True)
    lines = Printer(SCREEN, Capture(), extras=extras).lines("can0", records)
    told = [
        canwire.format_candump_line(LogLine(0, "can0", frame, direction), ascii=True, raw_dlc=True)
        for frame in content
        for direction in "RT"
    ]
    assert lines == told * 2
    assert Printer(SCREEN, Capture(), extras=Extras(messages=True)).lines("can0", records) == [
        canwire.format_candump_line(LogLine(0, "can0", frame, direction))
        for frame in content
        for direction in "RT"
    ] * 2  # fmt: skip


@each(
    ("level", "expected"),
    [
        (1, " (000.000000)\x1b[36m  can0\x1b[0m  123   [1]  11"),
        (2, " (000.000000)\x1b[36m  can0  123   [1]  11\x1b[0m"),
        (3, "\x1b[36m (000.000000)  can0  123   [1]  11\x1b[0m"),
    ],
)
def test_how_much_of_a_line_has_a_colour(level: int, expected: str) -> None:
    printer = Printer(SCREEN, Capture(), stamps=Stamps("z", 0), extras=Extras(colours=level))
    assert printer.lines("can0", [record_of(Frame(0x123, b"\x11"), 5)]) == [expected]


def test_extras_are_for_a_screen(capsys: pytest.CaptureFixture[str]) -> None:
    for words in (
        ["-a", "-l"],
        ["-x", "--json"],
        ["-c", "--pcapng", "-"],
        ["-8", "-l"],
        ["-S", "-l"],
        ["-s", "2", "-l"],
    ):
        assert main(["dump", "can0", *words]) == 2
        assert "for lines on a screen" in capsys.readouterr().err


def test_an_error_has_a_second_line_in_words() -> None:
    error = BusEvent(EventKind.ERROR, error=ErrorKind.STUFF, bit=23, rec=9)
    capture = parse_capture([], [], True)
    (text,) = Printer(SCREEN, capture).lines("can0", [record_of(error)])
    assert text.splitlines()[0] == canwire.format_candump_line(LogLine(0, "can0", error))
    assert (
        text.splitlines()[1] == "\tstuff error at bit 23 of the frame, receiving; error active, TEC 0, REC 9"
    )
    assert Printer(SCREEN, Capture()).lines("can0", [record_of(error)]) == []


@each(
    ("event", "words"),
    [
        (BusEvent(EventKind.ERROR, error=ErrorKind.ACK, transmitting=True, code=0xD9, tec=8, bit=31),
         "nobody acknowledged in the acknowledge slot, at bit 31 of the frame, sending; error active, TEC 8, REC 0"),
        (BusEvent(EventKind.STATE, state=ErrorState.BUS_OFF, tec=256),
         "the controller's state; bus-off, TEC 256, REC 0"),
        (BusEvent(EventKind.ARBITRATION_LOST, bit=12), "lost arbitration at bit 12; error active, TEC 0, REC 0"),
    ],
)  # fmt: skip
def test_events_in_words(event: BusEvent, words: str) -> None:
    assert in_words(event) == words


def test_every_event_has_words() -> None:
    assert all(in_words(BusEvent(kind)) for kind in EventKind)
    assert all(in_words(BusEvent(EventKind.ERROR, error=error)) for error in ErrorKind)


def test_names_and_signals() -> None:
    pytest.importorskip("cantools")
    decode = decoder(CAR)
    records = [record_of(Frame(0x100, bytes.fromhex("401F0A00"))), record_of(Frame(0x124))]
    assert Printer(SCREEN, Capture(), decode=decode).lines("can0", records) == [
        "  can0  100   [4]  40 1F 0A 00  :: Engine(Speed: 2000 rpm, Torque: 10 Nm)",
        "  can0  124   [0] ",
    ]
    known, other = map(json.loads, Printer(JSON, Capture(), decode=decode).lines("can0", records))
    assert (known["message"], known["signals"]) == ("Engine", {"Speed": 2000, "Torque": 10})
    assert "message" not in other
    databases = Databases([("", load_database(CAR))])
    assert databases.ids_of(["Engine"], "can0") == [(0x100, 0x7FF, False)]
    with pytest.raises(BadValue, match="Engine"):
        databases.ids_of(["Engin"], "can0")


def test_a_message_s_name_means_each_channel_s_own(tmp_path: Path) -> None:
    """One database's Engine is 100, the other's 200; a third channel has none."""
    pytest.importorskip("cantools")
    other = tmp_path / "other.dbc"
    other.write_text(Path(CAR).read_text().replace("BO_ 256 Engine", "BO_ 512 Engine"))
    databases = Databases([("can0", load_database(CAR)), ("can1", load_database(str(other)))])
    named = {
        channel: tuple(Masked(*one, inverted=False) for one in databases.ids_of(["Engine"], channel))
        for channel in ("can0", "can1", "can2")
    }
    printer = Printer(SCREEN, Capture(named=named))
    records = [record_of(Frame(id)) for id in (0x100, 0x200)]
    assert printer.lines("can0", records) == ["  can0  100   [0] "]
    assert printer.lines("can1", records) == ["  can1  200   [0] "]
    assert printer.lines("can2", records) == []
    with pytest.raises(BadValue, match="did you mean Engine"):
        databases.ids_of(["Engin"], "can2")


def test_swapped_bytes_as_candump_has_them() -> None:
    printer = Printer(SCREEN, Capture(), extras=Extras(ascii=True, swap=True))
    assert printer.lines("can0", [record_of(Frame(1, b"ABC"))]) == [
        "  can0  001   [3]  43`42`41                  `CBA`"
    ]


@pytest.mark.parametrize(("silent", "expected"), [(0, "  can0  001   [0] \n" * 2), (1, "-\b"), (2, "")])
def test_silent_lines_are_counted(silent: int, expected: str, capsys: pytest.CaptureFixture[str]) -> None:
    """And -n counts them, too."""
    lines = Lines(Printer(SCREEN, Capture()), silent)
    assert lines.put("can0", [record_of(Frame(1))] * 3, 2) == 2
    assert capsys.readouterr().out == expected
    assert lines.shown == {"can0": 2}


def test_lines_are_counted_though_a_signal_comes_as_they_are_written(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdout", Interrupted())
    lines = Lines(Printer(SCREEN, Capture()))
    with pytest.raises(KeyboardInterrupt):
        lines.put("can0", [record_of(Frame(1))] * 3, None)
    assert lines.shown == {"can0": 3}


class Interrupted(io.StringIO):
    """As Ctrl-C behind a call."""

    def write(self, text: str) -> int:
        super().write(text)
        raise KeyboardInterrupt


@pytest.mark.parametrize("room", ["79", "100000000000"])
def test_room_for_frames_that_wait(room: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dump", "can0", "-r", room]) == 2
    assert f"-r {room}: 80 to" in capsys.readouterr().err


def test_colours_tell_lines_and_errors_apart() -> None:
    error = record_of(BusEvent(EventKind.ERROR))
    printer = Printer(SCREEN, parse_capture([], [], True), coloured=True, several=True)
    (one,), (other,) = (
        printer.lines("can0", [record_of(Frame(1))]),
        printer.lines("body", [record_of(Frame(1))]),
    )
    assert one == "\x1b[36m  can0  001   [0] \x1b[0m"
    assert other == "\x1b[35m  body  001   [0] \x1b[0m"
    assert printer.lines("can0", [error])[0].startswith("\x1b[31m")
    alone = Printer(SCREEN, Capture(), coloured=True)
    assert alone.lines("can0", [record_of(Frame(1))]) == ["  can0  001   [0] "]


WORDS = {
    "log": False, "count": None, "timeout": 0.0, "seconds": None, "errors": False, "bus_name": False, "stamps": None,
    "json": False, "db": None, "pcapng": None, "ascii": False, "extra": False, "raw_dlc": False, "colour": 0,
    "swap": False, "silent": 0, "room": None,
}  # fmt: skip
TWO_BUSES = """
[[bus]]
name = "one"
[[bus]]
name = "two"
[[board]]
kind = "usb-to-can"
buses = ["one", "two"]
[[board]]
kind = "usb-to-can"
buses = ["one", "two"]
"""


def test_any_is_every_bus_in_the_order_of_time(capsys: pytest.CaptureFixture[str]) -> None:
    with (
        canwire.connect(time="virtual", config=canwire.Config.parse(TWO_BUSES)) as hub,
        ExitStack() as closing,
    ):
        places = places_of(hub, ["any"])
        assert [(name, place.address) for name, place in places] == [
            ("one", "HW000001:0"),
            ("two", "HW000001:1"),
        ]
        listening = closing.enter_context(Listening(hub, places, WantedMode()))
        sending = []
        for address in ("HW000002:0", "HW000002:1"):
            place = find_line(hub, address)
            channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
            channel.set_up(canwire.ChannelMode(receive=1, transmit=8))
            bring_up(hub, place, WantedMode())
            channel.activate()
            sending.append(channel)
        for at in (0, 1, 1, 0):
            sending[at].send(Frame(0x100 + at))
            hub.run_for(0.01)
        dump = Dump(Namespace(**{**WORDS, "stamps": "d"}), hub, listening, Capture())
        dump.run()
        assert dump.summary() == ["4 shown, 0 lost", "one: 2 shown, 0 lost", "two: 2 shown, 0 lost"]
        dump.run()  # nothing more has come
        sending[1].send(Frame(0x7FF))
        Dump(Namespace(**{**WORDS, "timeout": 1.0, "count": 1}), hub, listening, Capture()).run()
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[1] for line in lines[:4]] == ["one", "two", "two", "one"]
    assert lines[2].startswith(" (000.010000)")
    assert lines[4:] == ["  two  7FF   [0] "]


def test_it_ends_after_so_many_seconds(capsys: pytest.CaptureFixture[str]) -> None:
    with canwire.connect(time="virtual") as hub, ExitStack() as closing:
        listening = closing.enter_context(Listening(hub, places_of(hub, ["can0"]), WantedMode()))
        began_ns = hub.now_ns()
        Dump(Namespace(**{**WORDS, "timeout": None, "seconds": 2.5}), hub, listening, Capture()).run()
        assert hub.now_ns() - began_ns == 2_500_000_000


def test_a_line_that_was_meant_perhaps(hub_address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dump", "Can0", "--hub", hub_address]) == 2
    assert capsys.readouterr().err.endswith("; did you mean can0?\n")


def test_a_line_is_candumps(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = Namespace(**{**WORDS, "count": 2, "timeout": None, "stamps": "z"})
    with canwire.connect(time="virtual") as hub, ExitStack() as closing:
        listening = closing.enter_context(
            Listening(hub, [("can0", find_line(hub, "HW000001:0"))], WantedMode())
        )
        sender = find_line(hub, "HW000001:1")
        channel = closing.enter_context(hub.open_channel(sender.board.id, sender.line))
        channel.set_up(canwire.ChannelMode(receive=16, transmit=16))
        bring_up(hub, sender, WantedMode())
        channel.activate()
        for id in (0x100, 0x123, 0x200, 0x123):
            channel.send(Frame(id, b"\x11\x22"))
        Dump(arguments, hub, listening, parse_capture(["123:7FF"], [], False)).run()
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == " (000.000000)  can0  123   [2]  11 22"
    assert [line[13:] for line in lines] == ["  can0  123   [2]  11 22"] * 2
    parsed = [canwire.parse_candump_line(line) for line in lines]
    assert [line.content for line in parsed] == [
        Frame(0x123, b"\x11\x22", timestamp_ns=line.timestamp_ns) for line in parsed
    ]
