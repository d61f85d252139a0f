"""Node configuration and identification, request by request; bytes of reference/lin-protocol.md's vectors."""

from __future__ import annotations

from dataclasses import replace

import pytest

from canwire.errors import BadValue
from canwire.values.lin.configuration import LinNodeAttributes, LinProduct, LinSlaveConfiguration
from tests.cases import each

pytestmark = pytest.mark.conforms("N-47")

PRODUCT = LinProduct(0x7FF - 0x700, 0x2301, 0x45)  # 0x00FF
ATTRIBUTES = LinNodeAttributes(
    PRODUCT, nad=0x01, frames={0: 0x10, 1: 0x20}, serial=0x01020304, identifiers={33: b"\x05\x06"}
)
SILENT = None


def answer(slave: LinSlaveConfiguration, request: str, at_ns: int = 0) -> str | None:
    """Of a request of up to 8 bytes in hex; the first frame of what answers, without what fills it up."""
    slave.request(bytes.fromhex(request).ljust(8, b"\xff"), at_ns)
    found = slave.response(at_ns)
    if found is None:
        return None
    slave.fetched(at_ns)
    return found[: 2 + (found[1] & 0xF)].hex(" ").upper() if found[1] < 0x10 else found.hex(" ").upper()


@each(
    ("request_", "expected"),
    [
        ("01 06 B2 00 FF 7F FF FF", "01 06 F2 FF 00 01 23 45"),
        ("7F 06 B2 00 FF 7F FF FF", "01 06 F2 FF 00 01 23 45"),  # its own NAD in the answer
        ("01 06 B2 00 FF 00 01 23", "01 06 F2 FF 00 01 23 45"),
        ("01 06 B2 01 FF 7F FF FF", "01 05 F2 04 03 02 01"),
        ("01 06 B2 21 FF 7F FF FF", "01 03 F2 05 06"),
        ("01 06 B2 22 FF 7F FF FF", "01 03 7F B2 12"),
        ("01 06 B2 00 FE 00 FF FF", SILENT),  # another supplier
        ("01 06 B2 00 FF 7F 02 23", SILENT),  # another function
        ("02 06 B2 00 FF 7F FF FF", SILENT),  # another node
        ("7E 06 B2 00 FF 7F FF FF", SILENT),  # functional requests have no answer
        ("01 03 B2 00 FF", SILENT),
        ("01 06 B4 01 02 03 04 05", SILENT),  # no data dump
        ("01 06 B1 FF 7F 00 00 50", SILENT),  # LIN 2.0's, of a slave of 2.1
        ("01 06 B5 01 02 03 04 05", SILENT),
        ("01 02 22 01", SILENT),
        ("00 FF FF FF FF FF FF FF", SILENT),
    ],
)
def test_answers(request_: str, expected: str | None) -> None:
    assert answer(LinSlaveConfiguration(ATTRIBUTES), request_) == expected


def test_assign_nad() -> None:
    slave = LinSlaveConfiguration(ATTRIBUTES)
    assert answer(slave, "01 06 B0 FE 00 FF FF 02") is SILENT
    assert answer(slave, "01 06 B0 FF 7F FF FF 02") == "01 01 F0"  # V22, V23: by the initial NAD
    assert slave.nad == 0x02
    assert answer(slave, "01 06 B2 00 FF 7F FF FF") is SILENT
    assert answer(slave, "02 06 B2 00 FF 7F FF FF") == "02 06 F2 FF 00 01 23 45"
    assert answer(slave, "01 06 B0 FF 7F FF FF 03") == "01 01 F0"  # the initial one still assigns
    assert slave.nad == 0x03
    assert answer(slave, "03 06 B0 FF 7F FF FF 04") is SILENT


def test_assign_frame_id_range() -> None:
    slave = LinSlaveConfiguration(ATTRIBUTES)
    assert answer(slave, "01 06 B7 00 C1 42 FF FF") == "01 01 F7"  # V19, V20
    assert slave.identifiers == {0: 0x01, 1: 0x02}
    assert answer(slave, "01 06 B7 01 00 FF FF FF") == "01 01 F7"
    assert slave.identifiers == {0: 0x01, 1: None}
    assert answer(slave, "01 06 B7 01 42 C1 FF FF") is SILENT  # there is no frame 2: none of them
    assert answer(slave, "01 06 B7 00 01 42 FF FF") is SILENT  # no protected identifier
    assert slave.identifiers == {0: 0x01, 1: None}


def test_conditional_change_nad() -> None:
    slave = LinSlaveConfiguration(ATTRIBUTES)
    assert answer(slave, "01 06 B3 01 01 03 01 09") is SILENT  # serial's first byte is 4: bit 0 is not 1
    assert answer(slave, "01 06 B3 01 01 03 00 09") == "09 01 F3"
    assert answer(slave, "09 06 B3 00 05 FF 45 0A") == "0A 01 F3"
    assert answer(slave, "0A 06 B3 00 06 00 00 0B") is SILENT  # five bytes there are
    assert answer(slave, "0A 06 B3 30 01 00 00 0B") is SILENT
    assert slave.nad == 0x0A


def test_what_is_saved_stays() -> None:
    slave = LinSlaveConfiguration(ATTRIBUTES)
    answer(slave, "01 06 B7 00 C1 00 FF FF")
    assert answer(slave, "01 01 B6") == "01 01 F6"
    answer(slave, "01 06 B0 FF 7F FF FF 02")
    answer(slave, "02 06 B7 00 42 42 FF FF")
    slave.power_up()
    assert (slave.nad, slave.identifiers) == (0x01, {0: 0x01, 1: None})


def test_a_slave_of_lin_2_0_has_message_identifiers() -> None:
    slave = LinSlaveConfiguration(replace(ATTRIBUTES, frames={0x1001: 0x10}, message_ids=True))
    assert answer(slave, "01 06 B1 FF 7F 01 10 42") == "01 01 F1"
    assert slave.identifiers == {0x1001: 0x02}
    assert answer(slave, "01 06 B1 FF 7F 02 10 42") is SILENT
    assert answer(slave, "01 06 B7 00 C1 42 FF FF") is SILENT


def test_data_dump_and_other_services_are_the_users() -> None:
    asked: list[bytes] = []

    def read(payload: bytes) -> bytes:
        asked.append(payload)
        return b"\x62" + payload[1:] + bytes(10)

    slave = LinSlaveConfiguration(
        replace(ATTRIBUTES, data_dump=lambda data: data[::-1], service=read, p2_ns=1_000)
    )
    assert answer(slave, "01 06 B4 01 02 03 04 05") == "01 06 F4 05 04 03 02 01"
    assert answer(slave, "01 03 22 F1 90") is None  # not before P2
    assert slave.response(1_000) == bytes.fromhex("01 10 0D 62 F1 90 00 00")
    slave.fetched(1_000)
    assert slave.response(1_000) == bytes.fromhex("01 21 00 00 00 00 00 00")
    assert slave.response(1_001_001_000) is None  # N_As: nobody fetched it
    assert asked == [b"\x22\xf1\x90"]


def test_an_answer_is_for_the_last_request() -> None:
    slave = LinSlaveConfiguration(ATTRIBUTES)
    read = bytes.fromhex("0106B200FF7FFFFF")
    slave.request(read, 0)
    slave.request(bytes.fromhex("7E023E80FFFFFFFF"), 1)
    assert slave.response(1) is not None  # functional: it does not touch what is under way
    slave.request(bytes.fromhex("0506B200FF7FFFFF"), 2)
    assert slave.response(2) is None  # the next response is another node's


@each(
    ("change", "why"),
    [({"nad": 0x7E}, "nad 126"), ({"nad": 0}, "nad 0"), ({"identifiers": {1: b"1"}}, "identifier 1"),
     ({"identifiers": {32: bytes(6)}}, "6 bytes")],
)  # fmt: skip
def test_attributes_that_cannot_be(change: dict[str, object], why: str) -> None:
    with pytest.raises(BadValue, match=why):
        replace(ATTRIBUTES, **change)  # type: ignore[arg-type]
    with pytest.raises(BadValue, match="supplier 32767"):
        LinProduct(0x7FFF, 1)
