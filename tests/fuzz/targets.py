"""What is fuzzed: the parsers of tests/attacks/parsers.py, every reader of logs, every kind of description."""

from __future__ import annotations

import contextlib
import logging
import tempfile
import zlib
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import canwire.ecus
from canwire import (
    BadDescription,
    BadLog,
    BusEvent,
    ErrorKind,
    EventKind,
    Frame,
    LinFrame,
    LogEntry,
    LogLimits,
    LogMark,
    MarkKind,
    create_log,
    load_database,
    log_formats,
    open_log,
)
from canwire.logs.blf import layout as b
from tests.attacks.parsers import EXAMPLES, PARSERS, Parser, by_file

_ROOT = Path(__file__).parents[2]
_START_NS = 1_700_000_000_123_456_000
_LIMITS = LogLimits(block_bytes=1 << 20, channels=1000, memory_bytes=1 << 30, seconds=60)
_FOLDERS = ("trace",)  # these are no single file
_DESCRIPTIONS = {
    ".arxml": _ROOT / "tests" / "databases" / "data" / "engine.arxml",
    ".ldf": EXAMPLES / "door.ldf",
}


class NetOnlyError(Exception):
    """What a reader raised that is none of its own, and only Log's last net made a BadLog of."""


def targets(*, seeded: bool = True) -> dict[str, Parser]:
    """All of them, by name; those of logs without seeds cost nothing."""
    return {**PARSERS, **_logs(seeded), **_databases(), **_dictionaries()}


def _entries() -> list[LogEntry]:
    """Some of each kind, and enough of one for what reads runs of equal ones."""
    told = [
        LogEntry(_START_NS, "can0", LogMark(MarkKind.CLOCK, _START_NS, text="hub")),
        LogEntry(_START_NS, "can0", Frame(0x123, b"\x11\x22", timestamp_ns=_START_NS), "R"),
        LogEntry(_START_NS + 1000, "can1", Frame(0x1234567, extended=True, remote=True, dlc=3), "T"),
        LogEntry(
            _START_NS + 2000, "can0", Frame(0x7FF, bytes(range(64)), fd=True, bit_rate_switch=True), None
        ),
        LogEntry(_START_NS + 3000, "can0", BusEvent(EventKind.ERROR, error=ErrorKind.STUFF, bit=12)),
        LogEntry(_START_NS + 4000, "lin0", LinFrame(0x10, b"\x01\x02"), "R"),
        LogEntry(_START_NS + 5000, "lin0", LinFrame(0x11, header_only=True, length=4), "R"),
        LogEntry(_START_NS + 6000, "can0", LogMark(MarkKind.LOST, _START_NS, count=3)),
    ]
    return [*told, *(LogEntry(_START_NS + 10_000 * n, "can0", Frame(n, bytes(8)), "R") for n in range(12))]


def _logs(seeded: bool) -> dict[str, Parser]:
    rows = [(row.name, row.suffixes[0]) for row in log_formats() if row.name not in _FOLDERS and row.writes]
    return {
        f"log {name}": Parser(_reader(name, suffix), (BadLog,), _written(name, suffix) if seeded else ())
        for name, suffix in rows
    }


def _reader(form: str, suffix: str) -> Callable[[bytes], object]:
    def run(path: Path) -> None:
        try:
            with open_log(path, format=form, limits=_LIMITS) as log:
                for _ in log:
                    pass
                if form == "candump":
                    for _ in log.batches():
                        pass
        except BadLog as error:
            if error.__cause__ is not None:
                raise NetOnlyError(form) from error.__cause__
            raise

    return by_file(suffix, run)


@cache
def _written(form: str, suffix: str) -> tuple[bytes, ...]:
    """A log of that form with everything, one with a frame alone; without packing where there is one."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for entries in (_entries(), _entries()[1:2]):
            path = Path(folder) / f"seed{len(found)}{suffix}"
            with create_log(path, format=form) as log:
                for entry in entries:
                    with contextlib.suppress(ValueError):
                        log.write(entry)
            found.append(path.read_bytes())
    return (*map(_unpacked, found), *found) if form == "blf" else tuple(found)


def _unpacked(blf: bytes) -> bytes:
    """A BLF file whose containers are not packed, so that changes reach their objects."""
    made, at = bytearray(blf[: b.HEAD_SIZE]), b.HEAD_SIZE
    while at < len(blf):
        size = b.BASE.unpack_from(blf, at)[3]
        content = zlib.decompress(blf[at + b.CONTAINER_HEAD.size : at + size])
        whole = b.CONTAINER_HEAD.size + len(content)
        made += b.CONTAINER_HEAD.pack(
            b.OBJECT_MAGIC, 16, 1, whole, b.CONTAINER, b.NO_COMPRESSION, len(content)
        )
        made += content + bytes(whole % 4)
        at += size + size % 4
    return bytes(made)


def _databases() -> dict[str, Parser]:
    texts = {suffix: path.read_bytes() for suffix, path in _DESCRIPTIONS.items()}
    texts |= {".dbc": _DBC, ".sym": _SYM, ".kcd": _KCD}
    return {
        f"description {suffix}": Parser(by_file(suffix, load_database), (BadDescription,), (text,))
        for suffix, text in texts.items()
    }


def _dictionaries() -> dict[str, Parser]:
    """EDS files of CANopen, where its library is there."""
    if find_spec("canopen") is None:
        return {}
    logging.getLogger("canopen").setLevel(logging.CRITICAL)  # what it finds odd in a file that is odd
    seed = Path(canwire.ecus.CanopenEcu.EDS).read_bytes()
    return {
        "dictionary .eds": Parser(by_file(".eds", canwire.ecus.load_eds), (BadDescription,), (seed, _EDS))
    }


_EDS = b"""[DeviceInfo]
ProductName=small
[1000]
ParameterName=Device type
ObjectType=0x7
DataType=0x0007
AccessType=ro
DefaultValue=$NODEID+0x180
[2000]
ParameterName=Many
ObjectType=0x8
DataType=0x0003
AccessType=rw
CompactSubObj=3
[2000Name]
NrOfEntries=2
1=one
[2001]
ParameterName=Some
SubNumber=2
ObjectType=0x9
[2001sub0]
ParameterName=Count
DataType=0x0005
AccessType=const
DefaultValue=1
[2001sub1]
ParameterName=Value
DataType=0x0002
AccessType=rww
LowLimit=0x80
HighLimit=0x7F
[Comments]
Lines=1
Line1=x
"""
_DBC = b"""VERSION ""
NS_ :
BS_:
BU_: Engine Gauge
VAL_TABLE_ States 1 "on" 0 "off" ;
BO_ 291 Level: 8 Engine
 SG_ Mux M : 0|4@1+ (1,0) [0|15] "" Gauge
 SG_ Level m0 : 8|16@1- (0.5,-40) [-40|200] "%" Gauge
 SG_ Motor m1 : 31|8@0+ (1,0) [0|0] "" Gauge
BO_ 2566844926 Wide: 64 Engine
 SG_ Float : 0|32@1- (1,0) [0|0] "" Gauge
CM_ SG_ 291 Level "how much";
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_DEF_DEF_ "GenMsgCycleTime" 0;
BA_ "GenMsgCycleTime" BO_ 291 100;
VAL_ 291 Motor 1 "on" 0 "off" ;
SIG_VALTYPE_ 2566844926 Float : 1;
"""
_SYM = b"""FormatVersion=6.0 // Do not edit this line!
Title="Gauge"
{ENUMS}
Enum=State(0="off", 1="on")
{SENDRECEIVE}
[Gauge]
ID=123h
Len=4
CycleTime=100
Sig=Level 0
Sig=State 16
{SIGNALS}
Sig=Level unsigned 16 /u:% /f:0.5 /max:100
Sig=State unsigned 1 /e:State
"""
_KCD = b"""<?xml version="1.0" encoding="UTF-8"?>
<NetworkDefinition xmlns="http://kayak.2codeornot2code.org/1.0">
<Document name="x" version="1"/><Node id="1" name="Engine"/>
<Bus name="Body"><Message id="0x123" name="Gauge" length="4"><Producer><NodeRef id="1"/></Producer>
<Multiplex name="Mux" offset="0" length="2">
<MuxGroup count="0"><Signal name="A" offset="2" length="4"/></MuxGroup></Multiplex>
<Signal name="Level" offset="8" length="16">
<Value slope="0.5" unit="%"/><LabelSet><Label name="off" value="0"/></LabelSet></Signal>
</Message></Bus></NetworkDefinition>
"""
