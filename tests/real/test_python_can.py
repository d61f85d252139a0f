"""python-can's public API as its users take it, from one Bus to another; nothing here knows canwire but the name."""

from __future__ import annotations

import time
from collections.abc import Iterator

import can
import pytest

LONG = 30
pytestmark = pytest.mark.usefixtures("hub")


@pytest.fixture(params=[can.Bus, can.ThreadSafeBus], ids=["Bus", "ThreadSafeBus"])
def pair(request: pytest.FixtureRequest, hub: str) -> Iterator[tuple[can.BusABC, can.BusABC]]:
    arguments = {"interface": "canwire", "channel": "can0", "fd": True, "bitrate": 500_000}
    with request.param(**arguments) as one, request.param(**arguments) as other:
        yield one, other


MESSAGES = {
    "standard": can.Message(arbitration_id=0x123, is_extended_id=False, data=[1, 2, 3]),
    "extended": can.Message(arbitration_id=0x1ABCDEFF, is_extended_id=True, data=bytes(range(8))),
    "empty": can.Message(arbitration_id=0x7FF, is_extended_id=False),
    "remote": can.Message(arbitration_id=0x300, is_extended_id=False, is_remote_frame=True, dlc=5),
    "fd": can.Message(arbitration_id=0x5, is_extended_id=False, is_fd=True, data=bytes(64)),
    "fd, quick": can.Message(
        arbitration_id=0x1000, is_extended_id=True, is_fd=True, bitrate_switch=True, data=bytes(range(48))
    ),
}


@pytest.mark.parametrize("kind", MESSAGES)
def test_back_to_back(pair: tuple[can.BusABC, can.BusABC], kind: str) -> None:
    for sender, receiver in (pair, pair[::-1]):
        before = time.time()
        sender.send(MESSAGES[kind])
        got = receiver.recv(LONG)
        assert got is not None
        assert got.equals(MESSAGES[kind], timestamp_delta=None, check_channel=False, check_direction=False)
        assert before - 1 < got.timestamp < time.time() + 1
        assert sender.recv(0) is None


def test_iterating_and_timeouts(pair: tuple[can.BusABC, can.BusABC]) -> None:
    one, other = pair
    began = time.monotonic()
    assert other.recv(0.1) is None
    assert time.monotonic() - began >= 0.1
    for k in range(20):
        one.send(can.Message(arbitration_id=k, is_extended_id=False))
    heard = []
    for message in other:
        heard.append(message.arbitration_id)
        if message.arbitration_id == 19:
            break
    assert heard == list(range(20))


FILTERS = [
    None,
    [],
    [{"can_id": 0x100, "can_mask": 0x7FF}],
    [{"can_id": 0x100, "can_mask": 0x700, "extended": False}],
    [{"can_id": 0x100, "can_mask": 0x1FFFFFFF, "extended": True}, {"can_id": 0x2FF, "can_mask": 0x7FF}],
]


@pytest.mark.parametrize("filters", FILTERS)
def test_filters_say_what_comes(
    pair: tuple[can.BusABC, can.BusABC], filters: can.typechecking.CanFilters
) -> None:
    sender, receiver = pair
    tried = [(id, extended) for id in (0x100, 0x1FF, 0x2FF, 0x7FE) for extended in (False, True)]
    wanted = [
        (id, extended)
        for id, extended in tried
        if not filters
        or any(
            (id ^ one["can_id"]) & one["can_mask"] == 0 and one.get("extended", extended) == extended
            for one in filters
        )
    ]
    receiver.set_filters(filters)
    for id, extended in tried:
        sender.send(can.Message(arbitration_id=id, is_extended_id=extended))
    heard = []
    while len(heard) < len(wanted):
        got = receiver.recv(LONG)
        assert got is not None
        heard.append((got.arbitration_id, got.is_extended_id))
    assert heard == wanted
    assert receiver.recv(0.05) is None


def test_periodic_messages(pair: tuple[can.BusABC, can.BusABC]) -> None:
    sender, receiver = pair
    task = sender.send_periodic(MESSAGES["standard"], 0.01)
    assert isinstance(task, can.ModifiableCyclicTaskABC)
    stamps = []
    while len(stamps) < 20:
        got = receiver.recv(LONG)
        assert got is not None
        stamps.append(got.timestamp)
    mean_s = (stamps[-1] - stamps[0]) / 19
    assert mean_s == pytest.approx(0.01, abs=0.0005)
    task.modify_data(can.Message(arbitration_id=0x123, is_extended_id=False, data=[9, 9, 9]))
    while bytes(receiver.recv(LONG).data) != b"\t\t\t":
        pass
    task.stop()
    while receiver.recv(0.05) is not None:  # until nothing comes any more
        pass
    task.start()
    assert bytes(receiver.recv(LONG).data) == b"\t\t\t"
    sender.stop_all_periodic_tasks()


def test_a_notifier_and_a_buffered_reader(pair: tuple[can.BusABC, can.BusABC]) -> None:
    sender, receiver = pair
    reader = can.BufferedReader()
    with can.Notifier(receiver, [reader]):
        for k in range(50):
            sender.send(can.Message(arbitration_id=k, is_extended_id=False))
        assert [reader.get_message(LONG).arbitration_id for _ in range(50)] == list(range(50))
