"""The structures of ACAN.H, with their names and with the memory layout of 16-bit real mode.

    message = ACANMB(dwID=0x123 << 18, bLength=2, bData=b"\\x11\\x22")
    ACANMB.unpack(message.pack()) == message

They are packed and little-endian; a pointer is a far pointer with its offset in the low word. In Python a pointer field
holds the object itself (a buffer, a callable) or None; `pack()` needs a number in it, and `unpack()` returns one.
Source: INduCAN104 manual, "Data structures".
"""

# ruff: noqa: N815 - the fields have the manual's names
from __future__ import annotations

import dataclasses
from typing import Self

from canwire import BadValue
from canwire.acan.c_types import (
    ACANCBFN,
    BYTE,
    DWORD,
    EIGHT_BYTES,
    HANDLE,
    HWND,
    LPBYTE,
    LPVOID,
    ONE_BYTE,
    REFERENCE,
    TWO_BYTES,
    UINT,
    WORD,
)
from canwire.packed.layout import Misfit
from canwire.packed.record import Record, record


class Structure(Record):
    """The base of all structures. Assigning a value that does not fit a field raises BadValue."""

    __slots__ = ()

    def assign(self, other: Self) -> None:
        """Copy all fields of another structure, as C's `*this = *other` does."""
        for field in dataclasses.fields(other):  # type: ignore[arg-type]
            setattr(self, field.name, getattr(other, field.name))


@record()
class ACANHI(Structure):
    """Hardware configuration: machine and broadcast filters, clock (kHz), rate (kbit/s), bit timing (quanta).

    A 1 in a mask means that the bit is compared. `hi_ts1` includes the bit's first quantum (SYNC). Values that fit
    their fields can still give no valid bit timing: HardConfig checks that.
    """

    hi_miv: DWORD = 0
    hi_mim: DWORD = 0
    hi_biv: DWORD = 0
    hi_bim: DWORD = 0
    hi_clk: WORD = 0
    hi_rat: WORD = 0
    hi_ts1: BYTE = 0
    hi_ts2: BYTE = 0
    hi_sjw: BYTE = 0
    hi_msi: BYTE = 0
    hi_hsb: EIGHT_BYTES = bytes(8)

    @property
    def hi_ocr(self) -> int:
        """Output Control Register: hi_hsb[0]."""
        return self.hi_hsb[0]

    @hi_ocr.setter
    def hi_ocr(self, value: int) -> None:
        self.hi_hsb = bytes([_byte("hi_ocr", value)]) + self.hi_hsb[1:]

    @property
    def hi_ien(self) -> int:
        """Interrupt Enable Register: hi_hsb[1]; 0 means the default, 0xAD."""
        return self.hi_hsb[1]

    @hi_ien.setter
    def hi_ien(self, value: int) -> None:
        self.hi_hsb = self.hi_hsb[:1] + bytes([_byte("hi_ien", value)]) + self.hi_hsb[2:]


def _byte(name: str, value: int) -> int:
    try:
        return int(ONE_BYTE.fit(value))
    except Misfit as misfit:
        raise BadValue(f"ACANHI.{name}{misfit}") from None


@record()
class ACANMB(Structure):
    """A message. `dwID` has the identifier's first bit in bit 28, in both formats: see identifiers.py.

    `bFormat` holds Format flags; the message has the first `bLength` (0..8) bytes of `bData`.
    """

    dwID: DWORD = 0
    bFormat: BYTE = 0
    bLength: BYTE = 0
    bData: EIGHT_BYTES = bytes(8)


@record()
class ACANID(Structure):
    """A filter: a message passes if `dwID & dwAnd ^ dwXor` is 0. The Action flags in `bAction` say what happens then.

    A channel moves up to `bLength` (0..8) bytes into or out of `lpAddress`, any writable buffer.
    """

    dwAnd: DWORD = 0
    dwXor: DWORD = 0
    bAction: BYTE = 0
    bLength: BYTE = 0
    bReserved: TWO_BYTES = bytes(2)
    lpAddress: LPBYTE = None

    def passes(self, word: int) -> bool:
        """Whether a message with this ACAN identifier passes."""
        return word & self.dwAnd == self.dwXor


@record(eq=False)
class ACANTB(Structure):
    """A Task Block: what an application wants to receive, where the driver stores it, and how it notifies.

    As in C a Task Block is identified by its address: two are never equal. `lpBuf` gets retrieved messages: it is a
    writable buffer of `wCount * ACANMBSZ` bytes, or a list. `bNId` is the number of filters in `idTable`; 0 means all.
    An application is notified through `wTid` and `wEvent` (MS-DOS), through `hwnd` and `nMsg` (a queue and what is
    put into it), or through `hEvent` (any event); only MS-DOS's two fields are in memory. `on_change` is called, on
    any thread, when the driver has changed a field.
    """

    dwReserved0: DWORD = 0
    wTid: WORD = 0
    wEvent: WORD = 0
    cbNotification: ACANCBFN = None
    dwRefData: REFERENCE = 0
    bNotType: BYTE = 0
    bSCFilter: BYTE = 0
    wStatus: WORD = 0
    bREC: BYTE = 0
    bTEC: BYTE = 0
    bALC: BYTE = 0
    bECC: BYTE = 0
    lpRMB: LPVOID = None
    wRMBSize: WORD = 0
    wRMBOccupation: WORD = 0
    wRIndex: WORD = 0
    wWIndex: WORD = 0
    lpBuf: LPVOID = None
    wCount: WORD = 0
    bNId: BYTE = 0
    bReserved0: BYTE = 0
    dwReserved1: DWORD = 0
    dwReserved2: DWORD = 0
    dwReserved3: DWORD = 0
    dwFree: REFERENCE = 0
    dwReserved4: DWORD = 0
    idTable: list[ACANID] = dataclasses.field(default_factory=list)
    hwnd: HWND = None
    nMsg: UINT = 0
    hEvent: HANDLE = None
    on_change: HANDLE = None

    def __post_init__(self) -> None:
        self.bNId = self.bNId or len(self.idTable)

    def pack(self) -> bytes:
        """The Task Block in memory: `ACANTBSZ` bytes, then `bNId` filters of `ACANIDSZ` bytes.

        Raises BadValue for a pointer to a Python object, or if `idTable` has fewer than `bNId` filters.
        """
        if len(self.idTable) < self.bNId:
            raise BadValue(f"ACANTB.bNId is {self.bNId}: idTable has {len(self.idTable)} filters")
        return Structure.pack(self) + b"".join(one.pack() for one in self.idTable[: self.bNId])

    @classmethod
    def unpack(cls, data: bytes | bytearray | memoryview) -> Self:
        """The Task Block in `data`; raises BadValue unless `data` has exactly its size, with all its filters."""
        made = cls.unpack_head(data[: cls.SIZE])
        count = made.bNId
        table = bytes(data[cls.SIZE :])
        if len(table) != count * ACANIDSZ:
            raise BadValue(f"ACANTB with {count} filters needs {cls.SIZE + count * ACANIDSZ} bytes")
        made.idTable = [ACANID.unpack(table[at : at + ACANIDSZ]) for at in range(0, len(table), ACANIDSZ)]
        return made

    @classmethod
    def unpack_head(cls, data: bytes | bytearray | memoryview) -> Self:
        """The Task Block without its filters, from exactly `ACANTBSZ` bytes."""
        return super(ACANTB, cls).unpack(data)  # noqa: UP008 - record() makes the class again, with slots


ACANHISZ = ACANHI.SIZE
ACANMBSZ = ACANMB.SIZE
ACANIDSZ = ACANID.SIZE
ACANTBSZ = ACANTB.SIZE  # without the filters that follow it

# a pointer to a structure is the structure
PACANHI = LPACANHI = ACANHI
PACANMB = LPACANMB = ACANMB
PACANID = ACANID
PACANTB = LPACANTB = ACANTB
