"""LSS on the CANopen ECU: request by request as CiA 305 has them, and what a new node-ID changes."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from canwire import Frame, Lab

pytest.importorskip("canopen")

from canwire.ecus import CanopenEcu

pytestmark = pytest.mark.conforms("PP-04")
SELECT = [(0x40, 0), (0x41, 1), (0x42, 1), (0x43, 1)]
CONFIGURE = b"\x04\x01"


class Master:
    """A node that sends LSS requests, beside ECU 5."""

    def __init__(self, lab: Lab) -> None:
        self.lab = lab
        bus = lab.can_bus("can0", bit_rate=500_000)
        self.node = bus.node("master", receive_queue=256)
        self.ecu = CanopenEcu(5)
        bus.node("io", self.ecu)
        self.heard()

    def heard(self) -> list[tuple[int, bytes]]:
        self.lab.run_for(0.02)
        return [(frame.id, frame.data) for frame in self.node.receive_many(256)]

    def ask(self, *requests: bytes) -> list[bytes]:
        for request in requests:
            self.node.send(Frame(0x7E5, request.ljust(8, b"\0")))
        return [data for id, data in self.heard() if id == 0x7E4]

    def reset(self, code: int) -> set[int]:
        """NMT's command to all; the identifiers that were heard."""
        self.node.send(Frame(0, bytes([code, 0])))
        return {id for id, _ in self.heard()}


@pytest.fixture
def master() -> Iterator[Master]:
    with Lab() as lab:
        yield Master(lab)


def numbers(*pairs: tuple[int, int]) -> list[bytes]:
    return [bytes([code]) + number.to_bytes(4, "little") for code, number in pairs]


def test_one_device_is_selected_by_its_four_numbers(master: Master) -> None:
    assert master.ask(*numbers(*SELECT)) == [b"\x44".ljust(8, b"\0")]
    assert master.ecu.lss.configuring
    assert master.ask(b"\x04\x00") == []
    assert not master.ecu.lss.configuring


@pytest.mark.parametrize(
    "pairs",
    [[*SELECT[:3], (0x43, 2)], SELECT[1:], [SELECT[1], SELECT[0], *SELECT[2:]], [*SELECT[:1], *SELECT[2:]]],
)
def test_another_device_is_meant(master: Master, pairs: list[tuple[int, int]]) -> None:
    assert master.ask(*numbers(*pairs)) == []
    assert not master.ecu.lss.configuring


@pytest.mark.parametrize(("revisions", "answers"), [((0, 1), 1), ((1, 9), 1), ((2, 9), 0)])
def test_devices_in_a_range_are_found(master: Master, revisions: tuple[int, int], answers: int) -> None:
    low, high = revisions
    pairs = [(0x46, 0), (0x47, 1), (0x48, low), (0x49, high), (0x4A, 0), (0x4B, 0xFFFFFFFF)]
    assert master.ask(*numbers(*pairs)) == [b"\x4f".ljust(8, b"\0")] * answers


def test_numbers_are_told_while_it_is_configured(master: Master) -> None:
    assert master.ask(b"\x5b", b"\x5e") == []
    assert master.ask(CONFIGURE, b"\x5b", b"\x5e") == [
        b"\x5b\x01".ljust(8, b"\0"),
        b"\x5e\x05".ljust(8, b"\0"),
    ]


def test_a_node_id_holds_from_the_next_reset_on(master: Master) -> None:
    """For boot-up, SDO and the dictionary's identifiers; one that was not stored ends with the node's reset."""
    assert master.ask(CONFIGURE, b"\x11\x09") == [b"\x11".ljust(8, b"\0")]
    assert master.ecu.id == 5
    assert master.reset(130) == {0x709}
    master.node.send(Frame(0x609, bytes.fromhex("4000180100000000")))
    ((id, data),) = master.heard()
    assert (id, int.from_bytes(data[4:8], "little") & 0x7FF) == (0x589, 0x189)
    assert master.ask(b"\x5e") == [b"\x5e\x09".ljust(8, b"\0")]
    assert master.reset(129) == {0x705}
    assert master.ask(b"\x11\x09", b"\x17") == [b"\x11".ljust(8, b"\0"), b"\x17".ljust(8, b"\0")]
    assert master.reset(129) == {0x709}
    assert master.ecu.id == 9


def test_what_it_cannot_do_is_refused(master: Master) -> None:
    assert master.ask(CONFIGURE, b"\x11\x80", b"\x13\x00\x02") == [
        b"\x11\x01".ljust(8, b"\0"),
        b"\x13\x01".ljust(8, b"\0"),
    ]
    assert master.ask(b"\x51", b"\x99") == []
    master.node.send(Frame(0x7E5, b"\x5e"))
    assert master.heard() == []
