"""Gateways between buses of a hub, and of two hubs: frames cross once, by the rules, with an account."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from itertools import pairwise

import pytest

from canwire import (
    BadValue,
    ChannelMode,
    Frame,
    Gateway,
    GatewayRules,
    Hub,
    HubChannel,
    NoSuchBoard,
    WantedMode,
    bring_up,
)
from canwire.gateway import notes
from canwire.gateway.claim import Claim
from canwire.hub.finding import LinePlace, find_lines
from tests.hubs import LONG_S, connected, embedded

CONFIG = "".join(
    f'[[bus]]\nname = "can{number}"\ndata_bit_rate = 2000000\n'
    f'[[board]]\nkind = "usb-to-can-fd"\nbuses = ["can{number}", "can{number}"]\n'
    f'[[board]]\nkind = "usb-to-can-fd"\nbuses = ["can{number}", "can{number}"]\n'
    for number in range(3)
)


@pytest.fixture
def closing() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def hub(closing: ExitStack) -> Hub:
    return closing.enter_context(connected(closing.enter_context(embedded(CONFIG))))


def program(hub: Hub, name: str, closing: ExitStack) -> HubChannel:
    """Somebody else on that line, started at 500 kbit/s."""
    place: LinePlace = find_lines(hub, name, "CAN")[0]
    channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
    channel.set_up(ChannelMode(receive=4096, transmit=64))  # a test that stands still for 10 ms loses nothing
    control = bring_up(
        hub, place, lambda status: WantedMode(500_000).mode(place.info.capabilities), lambda status: None
    )
    if control is not None:
        control.close()
    channel.activate()
    return channel


def got(channel: HubChannel) -> Frame:
    frame = channel.receive(LONG_S)
    assert frame is not None
    return frame


@pytest.mark.smoke
@pytest.mark.conforms("PL-07", "N-34")
def test_both_ways_by_the_rules(hub: Hub, closing: ExitStack) -> None:
    here, there = program(hub, "can0", closing), program(hub, "can1", closing)
    rules = GatewayRules(filters=[(0x100, 0x700)], ids={0x100: 0x200})
    with Gateway("can0", "can1", there=rules, back=GatewayRules(), hub=hub) as gateway:
        for frame in (
            Frame(0x300),
            Frame(0x100, b"\x01"),
            Frame(0x101, bytes(12), fd=True, bit_rate_switch=True),
        ):
            here.send(frame)
        assert got(there) == Frame(0x200, b"\x01")
        assert got(there) == Frame(0x101, bytes(12), fd=True, bit_rate_switch=True)
        there.send(Frame(0x456, b"\x02"))
        assert got(here) == Frame(0x456, b"\x02")
        assert "running: there 2 passed, 1 filtered; " in repr(gateway)
    assert (gateway.there.heard, gateway.there.passed, gateway.there.filtered) == (3, 2, 1)
    assert (gateway.back.heard, gateway.back.passed) == (1, 1)
    assert repr(gateway).endswith("over: there 2 passed, 1 filtered; back 1 passed>")
    assert here.receive() is None  # nothing came back
    assert there.receive() is None


@pytest.mark.conforms("N-34")
def test_circles_are_refused_and_gateways_that_have_left_forgotten(hub: Hub) -> None:
    with Gateway("can0", "can1", hub=hub), Gateway("can1", "can2", hub=hub):
        with pytest.raises(BadValue, match="round and round: can2 > can0 > can1 > can2"):
            Gateway("can2", "can0", back=None, hub=hub)
        with pytest.raises(BadValue, match="round and round"):
            Gateway("can0", "can1", hub=hub)
        assert len(hub.notes("gateway/")) == 2
    with Gateway("can2", "can0", hub=hub):
        assert len(hub.notes("gateway/")) == 1
    assert hub.notes("gateway/") == {}


@pytest.mark.conforms("N-34")
@pytest.mark.finding("machines 12")
def test_a_ring_over_many_hubs_is_seen_and_forgotten_when_it_opens(closing: ExitStack) -> None:
    hubs = [closing.enter_context(connected(closing.enter_context(embedded(CONFIG)))) for _ in range(5)]
    joined = [
        closing.enter_context(Gateway("can0", "can0", back=None, hub=one, other_hub=other))
        for one, other in pairwise(hubs)
    ]
    for _ in joined:  # word goes one hub further with each look
        for gateway in joined:
            gateway._claimed.look()
    with pytest.raises(BadValue, match="round and round: " + " > ".join(["can0"] * 6)):
        Gateway("can0", "can0", back=None, hub=hubs[4], other_hub=hubs[0])
    with Gateway("can0", "can0", there=None, hub=hubs[4], other_hub=hubs[0]):
        pass  # two ways to one bus are no circle
    joined[1].close()
    for _ in range(40):
        for gateway in (joined[0], *joined[2:]):
            gateway._claimed.look()
    with Gateway("can0", "can0", back=None, hub=hubs[4], other_hub=hubs[0]):
        pass


@pytest.mark.conforms("N-34")
@pytest.mark.finding("machines 12")
def test_of_several_that_start_at_the_same_time_one_gives_way(hub: Hub) -> None:
    """Each has left its note before any has looked; the youngest sees a circle of older ones, nobody else does."""
    claims = [Claim(((hub, "h/can0"), (hub, "h/can1")), True, True, lambda n=n: n) for n in (7, 5, 5)]
    for claim in claims:
        notes.leave_ways(hub, claim._ways)
    oldest = min(claims, key=lambda claim: claim._ways[0].age)
    for claim in claims:
        if claim is oldest:
            claim.look()
        else:
            with pytest.raises(BadValue, match="round and round"):
                claim.look()


def test_a_hub_that_two_name_at_the_same_time_has_one_name(hub: Hub) -> None:
    hub.set_note("gateway-hub/bb", b"1")
    hub.set_note("gateway-hub/aa", b"1")
    assert notes.identity(hub, "cc") == "bb"


def test_a_program_that_dies_leaves_no_gateway_behind(hub: Hub, closing: ExitStack) -> None:
    with ExitStack() as other:
        engine = closing.enter_context(embedded(CONFIG))
        own = other.enter_context(connected(engine, "dies"))
        own.set_note("gateway/x", b'[["a", "b"]]', leaves=True)
        own.set_note("stays", b"1")
        witness = closing.enter_context(connected(engine, "witness"))
        assert list(witness.notes("")) == ["gateway/x", "stays"]
        other.close()
        assert list(witness.notes("")) == ["stays"]


@pytest.mark.conforms("N-34")
def test_between_two_hubs(hub: Hub, closing: ExitStack) -> None:
    other = closing.enter_context(connected(closing.enter_context(embedded(CONFIG))))
    here, there = program(hub, "can0", closing), program(other, "can0", closing)
    closing.enter_context(Gateway("can0", "can0", hub=hub, other_hub=other))
    here.send(Frame(1, b"there"))
    assert got(there) == Frame(1, b"there")
    there.send(Frame(2, b"back"))
    assert got(here) == Frame(2, b"back")
    with pytest.raises(BadValue, match="round and round: can0 > can0"):
        Gateway("can0", "can0", hub=other, other_hub=hub)


def test_refused_at_once(hub: Hub) -> None:
    with pytest.raises(BadValue, match="both lines are on can0"):
        Gateway("HW000001:0", "HW000002:1", hub=hub)
    with pytest.raises(BadValue, match="rules for one direction"):
        Gateway("can0", "can1", there=None, back=None, hub=hub)
    with pytest.raises(NoSuchBoard, match="can7"):
        Gateway("can0", "can7", hub=hub)
    assert hub.notes("gateway/") == {}


def test_what_ends_it_is_told(hub: Hub, closing: ExitStack) -> None:
    def broken(frame: Frame) -> Frame:
        raise ZeroDivisionError("in the program's own function")

    here = program(hub, "can0", closing)
    gateway = closing.enter_context(Gateway("can0", "can1", there=GatewayRules(change=broken), hub=hub))
    here.send(Frame(1))
    with pytest.raises(ZeroDivisionError):
        gateway.wait(LONG_S)
    assert "over" in repr(gateway)


@pytest.mark.finding("machines 9")
def test_passed_is_what_has_arrived_and_the_rest_is_accounted_for(hub: Hub, closing: ExitStack) -> None:
    here = program(hub, "can0", closing)
    there = program(hub, "can1", closing)
    gateway = closing.enter_context(Gateway("can0", "can1", back=None, hub=hub))
    here.send(Frame(1))
    assert got(there).id == 1
    hub.bus("can1").faults.short()
    for number in range(5):
        here.send(Frame(0x10 + number), timeout=LONG_S)
    while gateway.there.heard < 6:
        assert not gateway.wait(0.01)
    assert (gateway.there.passed, gateway.there.waiting) == (1, 5)
    gateway.close()
    assert (gateway.there.passed, gateway.there.given_up, gateway.there.waiting) == (1, 5, 0)
    assert str(gateway.there) == "1 passed, 5 given up"


def test_a_limit(hub: Hub, closing: ExitStack) -> None:
    here, there = program(hub, "can0", closing), program(hub, "can1", closing)
    gateway = closing.enter_context(Gateway("can0", "can1", there=GatewayRules(rate=10), hub=hub))
    for number in range(30):
        here.send(Frame(0x100, bytes([number])), timeout=LONG_S)
    assert [got(there).data[0] for _ in range(10)] == list(range(10))
    here.send(Frame(0x7FF), timeout=LONG_S)  # the last to be heard
    while gateway.there.heard < 31:
        assert not gateway.wait(0.01)
    assert (gateway.there.passed, gateway.there.limited) == (10, 21)
