"""Names and addresses: claims, what sockets hear, what they may send (SAE J1939-81, Linux' j1939.rst)."""

from __future__ import annotations

import errno
import struct

import pytest

from canwire.socketcan.j1939.endpoint import parse_filters
from canwire.socketcan.j1939.message import message_of
from tests.cases import each
from tests.socketcan.j1939.scene import Scene, Socket

LOW, HIGH = 0x11223340, 0x11223344
REQUEST = b"\x00\xee\x00"


@pytest.mark.conforms("N-49")
def test_a_claim_holds_after_a_quarter_of_a_second() -> None:
    scene = Scene()
    one, other = Socket(scene.node(), 0xFE, LOW), Socket(scene.node(), 0x30)
    one.claim(0x80)
    scene.run_for(0.2)
    with pytest.raises(OSError, match="assign") as refused:
        one.send(0x12300, b"early", 0x30)
    assert refused.value.errno == errno.EADDRNOTAVAIL
    scene.run_for(0.1)
    one.send(0x12300, b"now", 0x30)
    other.send(0x12300, b"back", to_name=LOW)
    scene.run_for(0.1)
    assert other.heard[-1].source_name == LOW
    assert (one.heard[-1].data, one.heard[-1].destination_name) == (b"back", LOW)
    assert scene.lines == ["18EEFF80 4033221100000000", "19233080 6e6f77", "19238030 6261636b"]


@pytest.mark.conforms("N-49")
@pytest.mark.parametrize("first", [LOW, HIGH])
def test_the_smaller_name_wins(first: int) -> None:
    scene = Scene()
    second = LOW + HIGH - first
    node = scene.node()
    one, two = Socket(node, 0xFE, first), Socket(scene.node(), 0xFE, second)
    one.claim(0x80)
    scene.run_for(0.3)
    two.claim(0x80)
    scene.run_for(0.3)
    assert node.network.addresses.name_of(0x80) == LOW
    assert node.network.addresses.address_of(LOW) == 0x80
    assert node.network.addresses.address_of(HIGH) == 0xFE


def test_a_claim_that_is_contested_in_time_never_holds() -> None:
    scene = Scene()
    node = scene.node()
    one, two = Socket(node, 0xFE, HIGH), Socket(scene.node(), 0xFE, LOW)
    one.claim(0x80)
    scene.run_for(0.1)
    two.claim(0x80)
    scene.run_for(0.3)
    assert node.network.addresses.address_of(LOW) == 0x80
    assert node.network.addresses.address_of(HIGH) == 0xFE


def test_who_cannot_claim_gives_its_address_back() -> None:
    scene = Scene()
    node = scene.node()
    one = Socket(node, 0xFE, LOW)
    one.claim(0x80)
    scene.run_for(0.3)
    one.claim(0xFE)
    scene.run_for(0.3)
    assert node.network.addresses.name_of(0x80) == 0
    with pytest.raises(OSError, match="assign"):
        one.send(0x12300, b"x", 0x30)
    one.send(0xEA00, REQUEST)
    scene.run_for(0.1)
    assert scene.lines[-1] == "18EAFFFE 00ee00"


@each("what", ["name", "length", "destination", "nobody"])
def test_claims_that_are_none(what: str) -> None:
    scene = Scene()
    one = Socket(scene.node(), 0xFF if what == "nobody" else 0x80, LOW)
    data = (HIGH if what == "name" else LOW).to_bytes(8, "little")[: 7 if what == "length" else 8]
    with pytest.raises(OSError, match="rotocol") as refused:
        one.send(0xEE00, data, 0x30 if what == "destination" else 0xFF)
    assert refused.value.errno == errno.EPROTO


def test_the_bus_goes_down_and_takes_all_claims() -> None:
    scene = Scene()
    node = scene.node()
    one = Socket(node, 0xFE, LOW)
    one.claim(0x80)
    scene.run_for(0.3)
    node.network.stop(errno.ENETDOWN)
    assert node.network.addresses.name_of(0x80) == 0


@each(
    ("identifier", "pgn", "source", "destination"),
    [(0x18EAFF20, 0xEA00, 0x20, 0xFF), (0x19F01330, 0x1F013, 0x30, 0xFF), (0x0C0B2A03, 0xB00, 3, 0x2A)],
)
def test_identifiers(identifier: int, pgn: int, source: int, destination: int) -> None:
    message = message_of(identifier, b"")
    assert (message.pgn, message.source, message.destination) == (pgn, source, destination)
    assert message.identifier == identifier


def heard_by(socket: Socket, *lines: str) -> list[str]:
    """Which of these frames it is given."""
    messages = [message_of(int(line.split()[0], 16), bytes.fromhex(line.split()[1])) for line in lines]
    found = zip(lines, messages, strict=True)
    return [line for line, message in found if socket.endpoint.hears(message)]


TO_IT, TO_ANOTHER, TO_ALL = "19233020 01", "19234020 02", "18FEEC21 03"


@pytest.mark.conforms("N-49")
def test_what_a_socket_hears() -> None:
    node = Scene().node()
    everything = (TO_IT, TO_ANOTHER, TO_ALL)
    assert heard_by(Socket(node, 0x30), *everything) == [TO_IT, TO_ALL]
    assert heard_by(Socket(node, 0x30, broadcasts=False), *everything) == [TO_IT]
    promiscuous = Socket(node, 0x30)
    promiscuous.endpoint.promiscuous = True
    assert heard_by(promiscuous, *everything) == list(everything)
    connected = Socket(node, 0x30)
    connected.endpoint.connected, connected.endpoint.peer_address = True, 0x21
    assert heard_by(connected, *everything) == [TO_ALL]
    of_pgn = Socket(node, 0x30)
    of_pgn.endpoint.pgn_heard = 0xFEEC
    assert heard_by(of_pgn, *everything) == [TO_ALL]


def test_filters() -> None:
    node = Scene().node()
    socket = Socket(node, 0x30)
    one, other = (
        struct.pack("<QQIIBB6x", 0, 0, 0xFEEC, 0x3FFFF, 0, 0),
        struct.pack("<QQIIBB6x", 0, 0, 0, 0, 0x20, 0xFF),
    )
    socket.endpoint.filters = parse_filters(one)
    assert heard_by(socket, TO_IT, TO_ALL) == [TO_ALL]
    socket.endpoint.filters = parse_filters(one + other)
    assert heard_by(socket, TO_IT, TO_ALL) == [TO_IT, TO_ALL]
    socket.endpoint.filters = parse_filters(struct.pack("<QQIIBB6x", LOW, (1 << 64) - 1, 0, 0, 0, 0))
    assert heard_by(socket, TO_IT, TO_ALL) == []
    for value in (one[:-1], one * 513):
        with pytest.raises(OSError, match="Invalid"):
            parse_filters(value)
