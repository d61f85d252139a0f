"""Block transfers of the CANopen ECU: by canopen's own client, and request by request as CiA 301 has them."""

from __future__ import annotations

from binascii import crc_hqx
from collections.abc import Iterator
from typing import Any

import pytest

from canwire import Frame, Lab

canopen = pytest.importorskip("canopen")

from canwire.ecus import CanopenEcu, LabCanopen  # noqa: E402

pytestmark = pytest.mark.conforms("PP-04")


class Client:
    """A node that asks the server of ECU 5 frame by frame."""

    def __init__(self, lab: Lab) -> None:
        self.lab = lab
        self.bus = lab.can_bus("can0", bit_rate=500_000)
        self.node = self.bus.node("client", receive_queue=4096)
        self.ecu = CanopenEcu(5)
        self.bus.node("io", self.ecu)
        self.index = next(one.index for one in self.ecu.object_dictionary.values() if one.name == "Label")
        self.object = self.index.to_bytes(2, "little") + b"\0"
        lab.run_for(0.01)
        self.node.receive_many(100)

    def ask(self, *requests: bytes) -> list[bytes]:
        """All of its answers to these."""
        for request in requests:
            self.node.send(Frame(0x605, request.ljust(8, b"\0")))
        self.lab.run_for(0.1)
        return [frame.data for frame in self.node.receive_many(4096) if frame.id == 0x585]

    def segments(self, data: bytes, first: int = 0, most: int = 127) -> list[bytes]:
        """One block of them."""
        parts = [data[at : at + 7] for at in range(first, len(data), 7)][:most]
        last = first + 7 * len(parts) >= len(data)
        return [
            bytes([number | (0x80 if last and number == len(parts) else 0)]) + part
            for number, part in enumerate(parts, 1)
        ]


@pytest.fixture
def client() -> Iterator[Client]:
    with Lab() as lab:
        yield Client(lab)


@pytest.mark.parametrize("size", [1, 7, 8, 889, 890, 2000])
def test_canopen_s_client_writes_and_reads_blocks(size: int) -> None:
    """Of one segment, of a whole block, and of several."""
    data = bytes(number % 94 + 33 for number in range(size))
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        master = LabCanopen(bus.node("master", transmit_queue=512, receive_queue=512))
        ecu = CanopenEcu(5)
        bus.node("io", ecu, transmit_queue=512)
        remote: Any = master.add_node(5, CanopenEcu.EDS)
        remote.nmt.wait_for_bootup(timeout=1)
        label = remote.sdo["Label"]
        with label.open("wb", size=size, block_transfer=True) as stream:
            stream.write(data)
        assert ecu.sdo["Label"].raw == data.decode()
        with label.open("rb", block_transfer=True) as stream:
            assert stream.read() == data


def test_segments_that_got_lost_are_asked_for_and_sent_again(client: Client) -> None:
    data = bytes(range(65, 86))
    (answer,) = client.ask(b"\xc6" + client.object + len(data).to_bytes(4, "little"))
    assert answer == b"\xa4" + client.object + bytes([127, 0, 0, 0])
    one, _, three = client.segments(data)
    assert client.ask(one, three) == [b"\xa2\x01\x7f" + bytes(5)]
    assert client.ask(*client.segments(data, 7)) == [b"\xa2\x02\x7f" + bytes(5)]
    crc = crc_hqx(data, 0).to_bytes(2, "little")
    assert client.ask(b"\xc1" + crc) == [b"\xa1" + bytes(7)]
    assert client.ecu.get_data(client.index, 0) == data


def test_an_upload_goes_on_behind_what_was_acknowledged(client: Client) -> None:
    data = bytes(range(65, 86))
    client.ecu.set_data(client.index, 0, data)
    (begun,) = client.ask(b"\xa4" + client.object + b"\x02")
    assert begun == b"\xc6" + client.object + (21).to_bytes(4, "little")
    one, two, three = (data[at : at + 7] for at in (0, 7, 14))
    assert client.ask(b"\xa3") == [b"\1" + one, b"\2" + two]
    assert client.ask(b"\xa2\x01\x7f") == [b"\1" + two, b"\x82" + three]
    crc = crc_hqx(data, 0).to_bytes(2, "little")
    assert client.ask(b"\xa2\x02\x7f") == [b"\xc1" + crc + bytes(5)]
    assert client.ask(b"\xa1") == []
    assert client.ask(b"\x40" + client.object)[0][0] == 0x41  # the next transfer is by segments


def test_a_short_object_may_come_as_usual(client: Client) -> None:
    client.ecu.set_data(client.index, 0, b"door")
    (answer,) = client.ask(b"\xa4" + client.object + b"\x7f\x0a")
    assert answer == b"\x43" + client.object + b"door"


@pytest.mark.parametrize(
    ("requests", "code"),
    [
        (["a4 OBJ 00"], 0x05040002),  # blocks of no segments
        (["a4 OBJ 80"], 0x05040002),
        (["a4 OBJ 7f", "a2 05 7f"], 0x05040003),  # more acknowledged than sent
        (["a4 OBJ 7f", "a0"], 0x05040001),
        (["c6 OBJ 02 00 00 00", "81 41 42", "d5 00 00"], 0x05040004),
        (["c2 OBJ 09 00 00 00", "81 41 42", "d5"], 0x06070013),
        (["c2 OBJ 01 00 00 00", "81 41 42", "d5"], 0x06070012),
        (["c2 OBJ 02 00 00 00", "81 41 42", "40 00 10 00"], 0x05040001),
    ],
)
def test_what_goes_wrong_is_aborted_with_its_code(client: Client, requests: list[str], code: int) -> None:
    """And the server takes the next request."""
    client.ecu.set_data(client.index, 0, b"front door")
    told = [bytes.fromhex(one.replace("OBJ", client.object.hex())) for one in requests]
    answers = client.ask(*told)
    assert answers[-1] == b"\x80" + client.object + code.to_bytes(4, "little")
    assert client.ask(b"\x40" + client.object)[0][0] == 0x41
    assert client.ecu.get_data(client.index, 0) == b"front door"


def test_an_abort_of_the_client_ends_a_transfer(client: Client) -> None:
    client.ask(b"\xc6" + client.object + (20).to_bytes(4, "little"), *client.segments(bytes(20))[:1])
    assert client.ask(b"\x80" + client.object + bytes(4)) == []
    client.ecu.set_data(client.index, 0, b"door")
    assert client.ask(b"\x40" + client.object)[0] == b"\x43" + client.object + b"door"


@pytest.mark.parametrize("reset", [True, False])
def test_a_transfer_that_nobody_goes_on_with_is_forgotten(client: Client, reset: bool) -> None:
    """A second later, or at a reset: what would else be a segment is a request."""
    client.ask(b"\xc6" + client.object + (20).to_bytes(4, "little"))
    assert client.ask(b"\x40" + client.object) == []
    if reset:
        client.node.send(Frame(0, b"\x81\x05"))
    client.lab.run_for(0.1 if reset else 1.0)
    client.node.receive_many(100)
    assert client.ask(b"\x40" + client.object)[0][0] == 0x41
