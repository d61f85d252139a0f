"""Every parser that takes what others wrote: what it is given, and what it may answer; for test_parsers.py and for
benchmarks/fuzz.py.

A parser takes bytes and raises nothing but what its row names; whatever else comes is a fault.
"""

from __future__ import annotations

import atexit
import shutil
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from canwire import (
    BadDescription,
    BadFrame,
    BadValue,
    CanwireError,
    parse_candump_line,
    parse_log_line,
    parse_slcan_frame,
)
from canwire.boards.config.configuration import Config
from canwire.errors import BadConfig, BadMessage, BadText
from canwire.hub.protocol import messages as m
from canwire.values.lin.text import parse_lin_content, parse_lin_log_line
from canwire.values.text import parse_content

EXAMPLES = Path(__file__).parents[2] / "examples"


class Parser(NamedTuple):
    """`run` has to raise one of `refuses`, or nothing. `seeds` are what it takes."""

    run: Callable[[bytes], object]
    refuses: tuple[type[Exception], ...]
    seeds: tuple[bytes, ...]


@cache
def scratch(suffix: str) -> Path:
    """A file for parsers that want one; in memory where there is such a place."""
    memory = Path("/dev/shm")
    folder = memory if memory.is_dir() else None
    made = tempfile.mkdtemp(prefix="canwire-parsers-", dir=folder)
    atexit.register(shutil.rmtree, made, ignore_errors=True)  # memory is not given back by itself
    return Path(made) / f"input{suffix}"


def by_file(suffix: str, parse: Callable[[Path], object]) -> Callable[[bytes], object]:
    """A parser of files."""

    def run(data: bytes) -> object:
        path = scratch(suffix)
        path.write_bytes(data)
        return parse(path)

    return run


def by_text(parse: Callable[[str], object]) -> Callable[[bytes], object]:
    """A parser of text, which is given any characters."""
    return lambda data: parse(data.decode("utf-8", "surrogateescape"))


def _slcan(data: bytes) -> None:
    parse_slcan_frame(data)
    parse_slcan_frame(data, fd=True)


def _requests(data: bytes) -> None:
    for payload in m.Inbox(m.LARGEST_REQUEST).feed(data):
        m.decode_request(payload)


def _replies(data: bytes) -> None:
    for payload in m.Inbox(m.LARGEST_REPLY).feed(data):
        m.decode_reply(payload)


def _candrv_messages(data: bytes) -> None:
    """In one piece and in two: the same messages, or the same refusal."""
    from canwire.candrv import MalformedMessage, MessageParser

    def messages(*pieces: bytes) -> object:
        parser, found = MessageParser(), []
        try:
            for piece in pieces:
                for message in parser.messages(piece):
                    found.append(message)
        except MalformedMessage as error:
            return found, str(error).partition(" at ")[0]
        return found, ""

    half = len(data) // 2
    whole = messages(data)
    parts = messages(data[:half], data[half:])
    assert whole == parts


def _candrv_event(data: bytes) -> None:
    from canwire.candrv import format_event, parse_event

    event = parse_event(data)
    assert parse_event(format_event(event)) == event


def _socketcan(data: bytes) -> None:
    """`can_frame` and `canfd_frame` as a program's library hands them on, and back."""
    import numpy

    from canwire.socketcan.wire import frames_received, records_to_send, sent_dtype, sound

    size = sent_dtype().itemsize
    rows = numpy.frombuffer(data[: len(data) // size * size], sent_dtype())
    rows = rows[sound(rows)]
    records = records_to_send(rows)
    assert len(records) == len(rows)
    assert len(frames_received(records, 1, 0)) == len(rows)


@cache
def _word() -> Any:
    from canwire.web.words import words_in

    return words_in("de")


def _web_fields(data: bytes) -> None:
    from canwire.web.fields import Fields

    fields = Fields({"x": data.decode("utf-8", "surrogateescape")}, _word())
    for read in (
        lambda: fields.text("x", longest=10),
        lambda: fields.flag("x"),
        lambda: fields.choice("x", ("1", "b")),
        lambda: fields.whole("x", 0, 2047),
        lambda: fields.real("x", 0, 10),
        lambda: fields.hexadecimal("x", 0, 0x7FF),
    ):
        read()
    fields.check()


def _web_row(data: bytes) -> None:
    """A record in hex, as a page asks for its details; half of the inputs are records of any content."""
    from canwire.web.trace.details import details_of

    text = data[:80].ljust(80, b"\0").hex() if len(data) % 2 else data.decode("utf-8", "surrogateescape")
    details_of(text, "", _database(), _word())


@cache
def _database() -> Any:
    from canwire.web.database import Database

    return Database()


class _Nobody:
    """A history and its taps, as far as a viewer's wish touches them."""

    total = 10

    def want(self, *_: object) -> None: ...


def _web_wish(data: bytes) -> None:
    """What a viewer of the trace says; the errors refused are those that end its connection."""
    from canwire.web.live import _parsed
    from canwire.web.trace.feed import Feed

    told = _parsed(data.decode("utf-8", "surrogateescape"))
    if isinstance(told, dict):
        nobody: Any = _Nobody()
        Feed(nobody, nobody)._hear(told)


def _bad_fields() -> type[Exception]:
    from canwire.web.fields import BadFields

    return BadFields


def _ini(path: Path) -> None:
    from canwire.commands.acan.wct import read_settings, write_settings

    settings = read_settings(path)
    write_settings(path, settings)
    assert read_settings(path) == settings


def _registry(path: Path) -> None:
    from canwire.candrv.registry.reg_file import load

    load(path)


def _candrv_table(path: Path) -> None:
    from canwire.candrv.registry.registry import RegistryStore

    store = RegistryStore(path)
    for device in store.devices():
        store.settings(device)


def _ldf(path: Path) -> None:
    from canwire import ldf

    ldf.load(path)


def _trace(text: str) -> None:
    from canwire.commands.acan.trace import parse_message

    parse_message(text)


_TOML = b"""[[bus]]
name = "can0"
bit_rate = 500000
length_m = 40
[[board]]
kind = "usb-to-can-fd"
serial = "HW123456"
buses = ["can0", "can0"]
[limits]
channels = 3
[candrv.CID1]
Board = "HW123456"
"""
_REG = b"""REGEDIT4
[HKEY_LOCAL_MACHINE\\Drivers\\BuiltIn\\CID1]
"Dll"="candrv.dll"
"Baudrate"=dword:0007A120
"Board"="HW000001"
"Align"=-
"""
_LDF = (EXAMPLES / "door.ldf").read_bytes() if (EXAMPLES / "door.ldf").exists() else b"LIN_description_file;"
_TEXT = (BadText, BadFrame)
_REQUESTS = (
    m.encode_request(1, m.ListBoards()),
    m.encode_request(2, m.Plug("usb-to-can", "", (), None, None, False, "", False)),
    m.encode_request(3, m.GetNote("x")),
)
_REPLIES = (m.encode_reply(1, m.Number(3)), m.encode_reply(0, m.BoardsChanged()))

PARSERS: dict[str, Parser] = {
    "frame text": Parser(
        by_text(parse_content),
        _TEXT,
        (b"123#11.22", b"18DB33F1##5AABB", b"7FF#R8", b"20000080#0000000000000000"),
    ),
    "log lines": Parser(
        by_text(parse_log_line),
        _TEXT,
        (b"(1436509052.249713) can0 123#11", b"(0.1) a 1F334455#R T"),
    ),
    "candump lines": Parser(
        by_text(parse_candump_line),
        _TEXT,
        (
            b" (000.000001)  can0  123   [2]  11 22",
            b"  can0  TX B -  123  [01]  11",
            b" can1 20000004 [8] 00 20 00 00 00 00 00 00   ERRORFRAME",
        ),
    ),
    "slcan lines": Parser(
        _slcan, (), (b"t1232AABB", b"T0000012381122334455667788", b"d1239" + b"00" * 12, b"r1231")
    ),
    "LIN text": Parser(
        by_text(parse_lin_content), _TEXT, (b"10#0102", b"2A#R", b"3C#0102030405060708 classic")
    ),
    "LIN log lines": Parser(by_text(parse_lin_log_line), _TEXT, (b"(1.5) lin0 10#0102",)),
    "ACAN's traces": Parser(by_text(_trace), _TEXT, (b"00000000001 - 61 62 63 | abc", b"00000000001 - 61")),
    "LDF": Parser(by_file(".ldf", _ldf), (BadDescription,), (_LDF,)),
    "canwire.toml": Parser(by_text(Config.parse), (BadConfig,), (_TOML, b"")),
    "CANDRV's tables": Parser(
        by_file(".toml", _candrv_table), (CanwireError,), (_TOML, b"[candrv.CID1]\nAlign = 1\n")
    ),
    "requests": Parser(m.decode_request, (BadMessage,), tuple(one[4:] for one in _REQUESTS)),
    "streams of requests": Parser(_requests, (BadMessage,), (b"".join(_REQUESTS), _REQUESTS[0])),
    "replies": Parser(m.decode_reply, (BadMessage,), tuple(one[4:] for one in _REPLIES)),
    "streams of replies": Parser(_replies, (BadMessage,), (b"".join(_REPLIES), _REPLIES[0])),
    "ACAN's INI": Parser(
        by_file(".ini", _ini),
        (BadConfig,),
        (b"[WCT]\r\nClock=16000\r\nRate=500\r\n", b"[Other]\na=b\n[wct]\nrate=100"),
    ),
    "CANDRV's messages": Parser(_candrv_messages, (), (b"731 0 4 11 22 33 44\n", b"1 1 8\n2 0 0\n")),
    "CANDRV's events": Parser(
        _candrv_event,
        (BadText, BadValue),
        (b"received\t0:5\t00000123\t0\t2\r\n\t61\t62\t0\n", b"bus error\t0:5\n"),
    ),
    "CANDRV's .reg": Parser(by_file(".reg", _registry), (BadConfig,), (_REG, _REG.decode().encode("utf-16"))),
    "can_frame": Parser(_socketcan, (), (bytes(200), b"\x23\x01\0\0\x08" + bytes(160))),
    "fields of the page": Parser(_web_fields, (_bad_fields(),), (b"1", b"-12", b"1,5", b"on")),
    "wishes of viewers": Parser(
        _web_wish,
        (ValueError, TypeError, KeyError),
        (
            b'{"look": {"number": 1, "lines": ["HW000001:0"]}, "ask": {"at": -1, "rows": 5}}',
            b'{"look": {"number": 1, "lines": [], "since": 1e999}}',
        ),
    ),
    "rows of the page": Parser(_web_row, (_bad_fields(),), (bytes(81), b"\x01" * 81, b"00" * 80)),
}
