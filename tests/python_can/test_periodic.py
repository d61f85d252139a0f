"""Periodic messages that the hub sends."""

from __future__ import annotations

import logging
from itertools import pairwise
from typing import Any

import can
import pytest
from can.broadcastmanager import ThreadBasedCyclicSendTask

import canwire
from canwire.python_can import CanwireBus
from canwire.python_can.periodic import HubTask
from tests.hubs import Served
from tests.python_can.programs import Open

LONG = 30


def message(*data: int) -> can.Message:
    return can.Message(arbitration_id=0x100, data=data, is_extended_id=False)


@pytest.fixture
def pair(hub: canwire.Hub) -> Any:
    """A sender and a receiver in virtual time."""
    with CanwireBus(hub=hub, receive_own_messages=True) as sender, CanwireBus(hub=hub) as receiver:
        yield sender, receiver


def received(bus: CanwireBus, count: int) -> list[can.Message]:
    found = [bus.recv(LONG) for _ in range(count)]
    return [one for one in found if one is not None]


@pytest.mark.conforms("PL-22")
def test_there_is_no_drift_over_an_hour(pair: Any, hub: canwire.Hub) -> None:
    sender, receiver = pair
    task = sender.send_periodic(message(1), 1.0)
    assert isinstance(task, HubTask)
    stamps = [one.timestamp for one in received(receiver, 3600)]
    task.stop()
    assert max(abs(stamp - stamps[0] - k) for k, stamp in enumerate(stamps)) < 1e-6


@pytest.mark.conforms("PL-22")
def test_a_millisecond(pair: Any) -> None:
    sender, receiver = pair
    with_others = [sender.send_periodic(message(k), 0.001) for k in range(5)]
    stamps: dict[int, list[float]] = {}
    for one in received(receiver, 500):
        stamps.setdefault(one.data[0], []).append(one.timestamp)
    for task in with_others:
        task.stop()
    assert set(stamps) == set(range(5))
    for times in stamps.values():
        errors = [abs(after - before - 0.001) for before, after in pairwise(times[1:])]
        assert sorted(errors)[len(errors) * 99 // 100] < 0.0003


def test_own_ones_are_own_ones(pair: Any) -> None:
    sender, receiver = pair
    with CanwireBus("HW000001:0", hub=sender._hub) as sibling:
        task = sender.send_periodic(message(1), 0.01)
        assert [one.is_rx for one in received(sender, 3)] == [False] * 3
        assert [one.is_rx for one in received(sibling, 3)] == [True] * 3
        task.stop()
    assert receiver.recv(0) is not None


def test_modified_data_go_out_in_the_same_ticks(pair: Any) -> None:
    sender, receiver = pair
    task = sender.send_periodic(message(1), 0.01)
    before = received(receiver, 3)
    task.modify_data(message(2, 3))
    after = received(receiver, 3)
    task.stop()
    assert [bytes(one.data) for one in before + after] == [b"\1"] * 3 + [b"\2\3"] * 3
    stamps = [one.timestamp for one in before + after]
    assert max(abs(stamp - stamps[0] - 0.01 * k) for k, stamp in enumerate(stamps)) < 50e-6
    with pytest.raises(ValueError, match="arbitration ID"):
        task.modify_data(can.Message(arbitration_id=1))


def test_several_messages_take_turns(pair: Any) -> None:
    sender, receiver = pair
    task = sender.send_periodic([message(k) for k in range(3)], 0.01, duration=0.07)
    found = []
    while (one := receiver.recv(0.5)) is not None:
        found.append(one)
    task.stop()
    assert [one.data[0] for one in found] == [0, 1, 2, 0, 1, 2, 0]
    stamps = [one.timestamp for one in found]
    assert max(abs(stamp - stamps[0] - 0.01 * k) for k, stamp in enumerate(stamps)) < 50e-6


def test_tasks_are_stored_stopped_and_begun_again(pair: Any) -> None:
    sender, receiver = pair
    stored = sender.send_periodic(message(1), 0.01)
    own = sender.send_periodic(message(2), 0.01, store_task=False, autostart=False)
    sender.stop_all_periodic_tasks()
    while receiver.recv(0.1) is not None:
        pass
    own.start()
    assert [one.data[0] for one in received(receiver, 3)] == [2] * 3
    own.stop()
    own.stop()
    stored.start()
    while receiver.recv(0.1).data[0] != 1:
        pass
    stored.stop()
    sender.shutdown()


def test_finished_tasks_make_room(pair: Any) -> None:
    sender, receiver = pair
    for k in range(40):
        task = sender.send_periodic(message(k), 0.01, duration=0.01)
        assert isinstance(task, HubTask)
        assert receiver.recv(1).data[0] == k


def test_what_does_not_fit_a_thread_sends(open_bus: Open, caplog: pytest.LogCaptureFixture) -> None:
    a, b = open_bus(), open_bus()
    tasks = [
        a.send_periodic(message(1), 1 / 3),
        a.send_periodic(message(1), 0.1, modifier_callback=lambda m: None),
    ]
    assert all(isinstance(task, ThreadBasedCyclicSendTask) for task in tasks)
    for task in tasks:
        task.stop()
    many = [a.send_periodic(message(k), 1.0) for k in range(17)]
    assert [isinstance(task, HubTask) for task in many] == [True] * 16 + [False]
    assert b.recv(LONG) is not None


def test_another_program_s_list(open_bus: Open, served: Served, caplog: pytest.LogCaptureFixture) -> None:
    a, b = open_bus("HW000001:0"), open_bus("HW000001:1")
    with canwire.connect(served.address, name="somebody") as hub:
        lease = hub.open_scheduler(hub.board("HW000001").id, 0)
        with caplog.at_level(logging.WARNING, "can.canwire"):
            task = a.send_periodic(message(1), 0.01)
        assert "held by somebody" in caplog.text
        assert b.recv(LONG) is not None
        task.stop()
        lease.close()
    again = a.send_periodic(message(1), 0.01)
    assert isinstance(again, HubTask)
    shared = open_bus("HW000001:0").send_periodic(message(2), 0.01)
    assert isinstance(shared, HubTask)
