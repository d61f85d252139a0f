"""Loops that ask again and again, and waits of a rest of nothing: time passes there, too."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable

import pytest

from canwire import Hub
from tests.cases import hold_for_each

can = pytest.importorskip("can")
pytestmark = [pytest.mark.finding("first-hour 1"), pytest.mark.timeout(60)]
REST_S = 1e-17  # what rounding leaves of the seconds of a clock


def sleeping(hub: Hub) -> None:
    time.sleep(REST_S)


def a_queue(hub: Hub) -> None:
    with pytest.raises(queue.Empty):
        queue.Queue[int]().get(timeout=REST_S)


def an_event(hub: Hub) -> None:
    threading.Event().wait(REST_S)


def a_receive(hub: Hub) -> None:
    with can.Bus("can0", interface="canwire", hub=hub) as bus:
        assert bus.recv(REST_S) is None


def the_hub(hub: Hub) -> None:
    hub.sleep(REST_S)


SHORT: dict[str, Callable[[Hub], None]] = {
    call.__name__: call for call in (sleeping, a_queue, an_event, a_receive, the_hub)
}


def test_the_shortest_wait_lets_some_time_pass(canwire_hub: Hub) -> None:
    def check(name: str) -> None:
        before_ns = canwire_hub.now_ns()
        SHORT[name](canwire_hub)
        assert canwire_hub.now_ns() > before_ns

    hold_for_each(SHORT, check)


@pytest.mark.parametrize("pause", [False, True], ids=["recv", "recv and sleep(0)"])
def test_who_only_asks_a_bus_gets_what_a_cyclic_task_sends(canwire_hub: Hub, pause: bool) -> None:
    with (
        can.Bus("can0", interface="canwire", hub=canwire_hub) as sender,
        can.Bus("can0", interface="canwire", hub=canwire_hub) as reader,
    ):
        sender.send_periodic(can.Message(arbitration_id=0x120, is_extended_id=False), 0.01)
        heard = 0
        while heard < 3:
            heard += reader.recv(0) is not None
            if pause:
                time.sleep(0)
    assert 20_000_000 < canwire_hub.now_ns() < 30_000_000


def test_a_timeout_is_over_when_its_wait_ends(canwire_hub: Hub) -> None:
    """Libraries ask for "later than the deadline" and for "not before": both are true then, as with any clock."""
    for _ in range(100):
        deadline_s = time.monotonic() + 0.1
        with pytest.raises(queue.Empty):
            queue.Queue[int]().get(timeout=0.1)
        assert time.monotonic() > deadline_s
