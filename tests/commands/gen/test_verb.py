"""`canwire gen` on a hub: what arrives, when, and what it says of what did not."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import islice, repeat

import pytest

import canwire
from canwire import BusEvent, ChannelMode, Frame, Hub, HubChannel, LinePlace, WantedMode
from canwire.commands import main
from canwire.commands.can_line import bring_up
from canwire.commands.gen.sending import Generator
from canwire.commands.shared_hub import find_line


@pytest.fixture
def hub() -> Iterator[Hub]:
    with canwire.connect(time="virtual") as made:
        yield made


@pytest.fixture
def closing() -> Iterator[ExitStack]:
    with ExitStack() as made:
        yield made


def on(hub: Hub, address: str, closing: ExitStack, receive: int = 4096) -> tuple[LinePlace, HubChannel]:
    place = find_line(hub, address)
    channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
    channel.set_up(ChannelMode(receive=receive, transmit=64))
    bring_up(hub, place, WantedMode())
    channel.activate()
    return place, channel


def test_frames_go_out_in_their_times(hub: Hub, closing: ExitStack) -> None:
    _, receiver = on(hub, "HW000002:0", closing)
    hub.run_for(1)
    generator = Generator(hub, *on(hub, "HW000001:0", closing), 1.0)
    hub.run_for(1)
    began_ns = hub.now_ns()
    assert generator.run(islice(repeat((0.01, Frame(0x123))), 50), None) == 0
    times = [frame.timestamp_ns - began_ns for frame in receiver.receive_many(100)]
    assert [time // 10_000_000 for time in times] == list(range(1, 51))
    counts = generator.counts()
    assert counts[:4] == (50, 50, 0, 0)
    assert counts.late_s == 0
    assert 0.5 <= counts.seconds <= 1.5  # and what it waited for the last one


def test_the_time_ends_it(hub: Hub, closing: ExitStack) -> None:
    on(hub, "HW000002:0", closing)
    generator = Generator(hub, *on(hub, "HW000001:0", closing), 1.0)
    assert generator.run(repeat((0.1, Frame(1))), 1.05) == 0
    assert generator.counts().sent == 10


def test_traffic_without_an_end_waits_while_nobody_listens(
    hub: Hub, closing: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    receivers: list[HubChannel] = []

    def somebody_comes(text: str) -> None:
        said.append(text)
        hub.run_for(20)  # many times as long as the timeout
        receivers.append(on(hub, "HW000002:0", closing)[1])

    monkeypatch.setattr("canwire.commands.send.complain", somebody_comes)
    generator = Generator(hub, *on(hub, "HW000001:0", closing), 0.1)
    assert generator.run(((0.0, Frame(number)) for number in range(100)), None, endless=True) == 0
    assert len(said) == 1
    assert "the bus takes no frames: nobody acknowledges" in said[0]
    assert generator.counts()[:4] == (100, 100, 0, 0)
    assert [frame.id for frame in receivers[0].receive_many(200)] == list(range(100))


def test_a_time_ends_what_waits(hub: Hub, closing: ExitStack, capsys: pytest.CaptureFixture[str]) -> None:
    generator = Generator(hub, *on(hub, "HW000001:0", closing), 0.1)
    assert generator.run(repeat((0.0, Frame(1))), 5.0, endless=True) == 1
    assert generator.counts().seconds >= 5
    assert capsys.readouterr().err.count("the bus takes no frames") == 1


def test_nobody_acknowledges(hub: Hub, closing: ExitStack, capsys: pytest.CaptureFixture[str]) -> None:
    generator = Generator(hub, *on(hub, "HW000001:0", closing), 0.1)
    assert generator.run(islice(repeat((0.0, Frame(1))), 100), None) == 1
    counts = generator.counts()
    assert (counts.sent, counts.refused) == (0, 0)
    assert (
        counts.generated == counts.not_acknowledged == 66
    )  # the queue, the controller, one that found no room
    assert "nobody acknowledges" in capsys.readouterr().err
    assert str(counts).startswith("0 sent, 0 refused, 66 not acknowledged in ")
    _, receiver = on(hub, "HW000002:0", closing)
    hub.run_for(1)
    assert receiver.receive_many(10) == []  # nothing goes out afterwards


def test_what_the_line_cannot_send_is_refused(hub: Hub, closing: ExitStack) -> None:
    on(hub, "HW000001:0", closing)
    generator = Generator(hub, *on(hub, "HW000002:0", closing), 1.0)
    plan = [(0.0, Frame(1)), (0.0, Frame(2, bytes(12), fd=True)), (0.0, Frame(3))]
    assert generator.run(plan, None) == 1
    assert generator.counts()[:4] == (3, 2, 1, 0)


def test_more_than_the_bus_can_take_is_told(hub: Hub, closing: ExitStack) -> None:
    on(hub, "HW000002:0", closing, receive=1)
    generator = Generator(hub, *on(hub, "HW000001:0", closing), 10.0)
    frame = Frame(1, bytes(8))
    assert generator.run(islice(repeat((0.00001, frame)), 2000), None) == 0  # 100,000 frames/s on 500 kbit/s
    counts = generator.counts()
    assert counts.sent == 2000
    assert counts.late_s > 0.3
    assert "behind the plan" in str(counts)
    assert generator.run(islice(repeat((0.0, frame)), 2000), None) == 0
    assert generator.counts().late_s == counts.late_s  # without gaps there is no plan to be behind


@pytest.mark.conforms("PC-10", "PC-11")
def test_the_verb(hub_address: str, capsys: pytest.CaptureFixture[str]) -> None:
    with canwire.connect(hub_address) as hub, ExitStack() as closing:
        _, receiver = on(hub, "HW000002:0", closing)
        words = ["gen", "HW000001:0", "--gap", "0", "-n", "20", "--seed", "7", "--hub", hub_address]
        assert main([*words, "--json"]) == 0
        first = receiver.receive_many(100, timeout=1)
        numbers = json.loads(capsys.readouterr().out)
        assert (numbers["generated"], numbers["sent"]) == (20, 20)
        assert main(words) == 0
        told = capsys.readouterr()
        assert told.out == ""
        assert "--seed 7" in told.err
        assert "canwire: 20 sent, 0 refused, 0 not acknowledged" in told.err
        assert [
            frame for frame in receiver.receive_many(100, timeout=1) if not isinstance(frame, BusEvent)
        ] == first
        assert len(first) == 20


@pytest.mark.realtime
def test_a_share_of_the_bus(hub_address: str) -> None:
    """The bus's own figure agrees; timing of a busy machine may only make it less."""
    with canwire.connect(hub_address) as hub, ExitStack() as closing:
        place, _ = on(hub, "HW000002:0", closing)
        assert main(["gen", "HW000001:0", "--load", "40", "--seconds", "1.2", "--hub", hub_address]) == 0
        assert 0 < place.status(hub).load < 45


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--count", "0"), "--count 0: 1 or more"),
        (("--gap", "-1"), "--gap -1.0: 0 or more"),
        (("--rate", "0"), "--rate 0: more than 0"),
        (("--db", "x.dbc", "--load", "3"), "leave --load and --rate out"),
        (("--message", "Engine"), "--message: names a message of --db"),
        (("--id", "xyz"), "--id 'xyz'"),
        (("--load", "101"), "--load 101"),
        (("--db", "x.dbc"), "x.dbc: No such file"),
    ],
)
def test_mistakes(
    hub_address: str, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], why: str
) -> None:
    assert main(["gen", "can0", *words, "--hub", hub_address]) == 2
    assert why in capsys.readouterr().err
