"""What the standard library's waits and clocks do in a hub's virtual time; nothing here waits for the wall clock."""

from __future__ import annotations

import asyncio
import concurrent.futures
import os
import queue
import select
import selectors
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from time import monotonic as imported_monotonic

import pytest

import canwire
from canwire import Hub, HubError
from tests.cases import hold_for_each

pytestmark = [pytest.mark.conforms("N-61"), pytest.mark.timeout(60)]
WAITS: dict[str, Callable[[], object]] = {}


def lasts(seconds: float) -> Callable[[Callable[[], object]], Callable[[], object]]:
    def note(wait: Callable[[], object]) -> Callable[[], object]:
        WAITS[f"{wait.__name__}: {seconds}"] = wait
        return wait

    return note


@lasts(3600)
def sleeping() -> None:
    time.sleep(3600)


@lasts(2)
def an_event_that_nobody_sets() -> None:
    assert not threading.Event().wait(2)


@lasts(3)
def a_condition() -> None:
    with (condition := threading.Condition()):
        assert not condition.wait(3)
        assert not condition.wait_for(lambda: False, 0)


@lasts(4)
def a_lock_that_is_held() -> None:
    lock = threading.Lock()
    with lock:
        assert not lock.acquire(timeout=4)
    assert lock.acquire(blocking=False)


@lasts(5)
def a_semaphore() -> None:
    assert not threading.Semaphore(0).acquire(timeout=5)


@lasts(6)
def a_queue() -> None:
    with pytest.raises(queue.Empty):
        queue.Queue[int]().get(timeout=6)


@lasts(7)
def a_simple_queue() -> None:
    with pytest.raises(queue.Empty):
        queue.SimpleQueue[int]().get(timeout=7)


@lasts(8)
def a_full_queue() -> None:
    (full := queue.Queue[int](1)).put(1)
    with pytest.raises(queue.Full):
        full.put(2, timeout=8)


@lasts(9)
def a_timer() -> None:
    timer = threading.Timer(9, lambda: None)
    timer.start()
    timer.join()
    assert not timer.is_alive()


@lasts(1)
def joining_a_thread_that_takes_longer() -> None:
    thread = threading.Thread(target=time.sleep, args=(2,), daemon=True)
    thread.start()
    thread.join(1)
    assert thread.is_alive()


@lasts(10)
def descriptors() -> None:
    reader, writer = socket.socketpair()
    with reader, writer:
        assert select.select([reader], [], [], 4) == ([], [], [])
        poll = select.poll()
        poll.register(reader, select.POLLIN)
        assert poll.poll(3000) == []
        with selectors.DefaultSelector() as selector:
            selector.register(reader, selectors.EVENT_READ)
            assert selector.select(3) == []
            threading.Thread(target=writer.send, args=(b"x",)).start()
            assert len(selector.select()) == 1
        assert select.select([reader], [], [])[0] == [reader]
        assert poll.poll() == [(reader.fileno(), select.POLLIN)]


@lasts(3)
def futures() -> None:
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        waiting = [pool.submit(time.sleep, seconds) for seconds in (2, 1, 2)]
        assert [done.result() for done in concurrent.futures.as_completed(waiting)] == [None] * 3


@lasts(62)
def asyncio_with_a_thread() -> None:
    async def main() -> None:
        async with asyncio.timeout(100):
            await asyncio.gather(asyncio.sleep(60), asyncio.to_thread(time.sleep, 61))
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(asyncio.get_running_loop().create_future(), 1)

    asyncio.run(main())


@lasts(5)
def polling_the_clock() -> None:
    end_s = imported_monotonic() + 5
    while time.perf_counter() < end_s:
        pass


@lasts(0)
def another_process() -> None:
    """It goes by the computer's time: this one's stands meanwhile."""
    subprocess.run([sys.executable, "-c", ""], check=True, timeout=60)


def test_waits_last_as_long_as_they_say_in_the_hubs_time(canwire_hub: Hub) -> None:
    def check(case: str) -> None:
        began_ns = canwire_hub.now_ns()
        WAITS[case]()
        lasted_s = (canwire_hub.now_ns() - began_ns) / 1e9
        assert float(case.partition(": ")[2]) <= lasted_s <= float(case.partition(": ")[2]) + 0.002

    hold_for_each(WAITS, check)


def test_clocks_are_the_hubs(canwire_hub: Hub) -> None:
    canwire_hub.run_for(1.5)
    seconds = [time.time(), time.monotonic(), time.perf_counter(), imported_monotonic()]
    assert seconds == [1.5] * 4
    assert [time.time_ns(), time.monotonic_ns(), time.perf_counter_ns()] == [1_500_000_000] * 3


def test_afterwards_everything_is_as_it_was() -> None:
    before = [
        time.sleep,
        time.monotonic,
        threading.Lock,
        threading.Thread.start,
        select.select,
        queue.SimpleQueue,
    ]
    with canwire.connect(time="virtual") as hub, canwire.in_time(hub):
        kept = threading.Lock()
        assert time.sleep is not before[0]
    after = [
        time.sleep,
        time.monotonic,
        threading.Lock,
        threading.Thread.start,
        select.select,
        queue.SimpleQueue,
    ]
    assert after == before
    assert kept.acquire(timeout=1)
    assert not kept.acquire(timeout=0.001)


def test_who_waits_at_the_end_goes_on_by_the_clock() -> None:
    ended = threading.Event()

    def wait_and_tell(inside: threading.Event) -> None:
        inside.wait()
        ended.set()

    with canwire.connect(time="virtual") as hub, canwire.in_time(hub):
        inside = threading.Event()
        threading.Thread(target=wait_and_tell, args=(inside,), daemon=True).start()
        time.sleep(1)
    inside.set()
    assert ended.wait(30)


def test_a_wait_that_nothing_can_end_names_threads_and_what_they_wait_for(canwire_hub: Hub) -> None:
    lock = threading.Lock()
    lock.acquire()
    thread = threading.Thread(target=lock.acquire, name="stuck", daemon=True)
    thread.start()
    with pytest.raises(HubError) as refused:
        thread.join()
    text = str(refused.value)
    assert "'MainThread' waits for thread 'stuck' to end" in text
    assert f"{os.path.basename(__file__)}:" in text
    assert "'stuck' waits for a lock" in text


def test_an_error_in_a_thread_is_shown_and_the_others_go_on(
    canwire_hub: Hub, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[object] = []
    monkeypatch.setattr(threading, "excepthook", lambda args: shown.append(args.exc_type))
    thread = threading.Thread(target=lambda: 1 // 0)
    thread.start()
    thread.join()
    assert shown == [ZeroDivisionError]


def test_who_is_away_is_waited_for_by_nobody(canwire_hub: Hub) -> None:
    outside = threading.Thread(target=lambda: None)
    with canwire_hub.away():
        outside.start()  # no thread of the company's
        outside.join()
    assert canwire_hub.now_ns() == 0
    time.sleep(1)
    assert canwire_hub.now_ns() == 1_000_000_000


@pytest.fixture(autouse=True)
def no_thread_is_left_in_a_company() -> Iterator[None]:
    from canwire.threads.member import MEMBERS

    yield
    assert not MEMBERS or list(MEMBERS) == [threading.get_ident()]
