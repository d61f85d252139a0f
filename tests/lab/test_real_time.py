"""The bench at the speed of the wall clock. Only lower bounds are asserted: a loaded machine may be late."""

from __future__ import annotations

import asyncio
import itertools
import statistics
import threading
from collections.abc import Callable, Iterator

import pytest

from canwire import BusOff, Frame, Lab, NodeScript

pytestmark = [pytest.mark.core, pytest.mark.realtime]

C04 = Frame(0x123, b"\x11\x22")
AGES = 60.0  # seconds; only a broken build waits that long


@pytest.fixture
def real() -> Iterator[Lab]:
    with Lab(time="real") as lab:
        yield lab


@pytest.mark.smoke
@pytest.mark.conforms("G-18")
def test_frames_arrive(real: Lab) -> None:
    bus = real.can_bus()
    a, b = bus.node("a"), bus.node("b")
    a.send_many([C04, Frame(0x2AA, b"\xaa" * 8)])
    assert b.receive(timeout=AGES) == C04
    assert b.receive(timeout=AGES) == Frame(0x2AA, b"\xaa" * 8)
    assert (a.delivered, bus.error_frames) == (2, 0)


@pytest.mark.conforms("G-18")
def test_receive_blocks_until_the_frame_is_over(real: Lab) -> None:
    bus = real.can_bus(bit_rate=10_000)  # 6.2 ms a frame
    a, b = bus.node("a"), bus.node("b")
    before_ns = real.now_ns
    a.send(C04)
    frame = b.receive(timeout=AGES)
    assert frame is not None
    assert frame.timestamp_ns - before_ns >= 62 * 100_000
    assert real.now_ns >= frame.timestamp_ns


def test_receive_gives_up_not_before_its_timeout(real: Lab) -> None:
    b = real.can_bus().node("b")
    before_ns = real.now_ns
    assert b.receive(timeout=0.02) is None
    assert real.now_ns - before_ns >= 19_000_000


def test_time_passes_by_itself(real: Lab) -> None:
    before_ns = real.now_ns
    real.run_for(0.01)
    assert real.now_ns - before_ns >= 10_000_000
    real.run_until(real.now_ns + 5_000_000)
    assert real.now_ns - before_ns >= 15_000_000


def test_run_until_idle_waits_for_the_last_frame(real: Lab) -> None:
    bus = real.can_bus(bit_rate=50_000)
    a, b = bus.node("a"), bus.node("b")
    before_ns = real.now_ns
    a.send_many([Frame(k) for k in range(10)])
    real.run_until_idle()
    assert [frame.id for frame in b.receive_many(99)] == list(range(10))
    assert real.now_ns - before_ns >= 10 * 44 * 20_000


class Ticker(NodeScript):
    def on_start(self) -> None:
        self.every(0.005, lambda: self.send(Frame(0x100)))


@pytest.mark.conforms("G-18")
def test_spacing_and_lateness_are_reported(real: Lab) -> None:
    """No frame of a period comes early; how late each happening was, the lab says."""
    bus = real.can_bus()
    bus.node("a", Ticker())
    b = bus.node("b")
    frames = [b.receive(timeout=AGES) for _ in range(10)]
    received_ns = real.now_ns
    times = [frame.timestamp_ns for frame in frames if frame is not None]
    assert len(times) == 10
    assert times == sorted(set(times))
    assert times[-1] >= 10 * 5_000_000 + 44 * 2000
    assert received_ns >= times[-1]  # the clock of the wall: both begin with the lab
    lateness = real.lateness_ns()
    assert len(lateness) >= 20
    assert min(lateness) >= 0
    # the mean error of frame spacing at the wall clock is the mean difference of two latenesses
    error_ns = statistics.mean(abs(later - earlier) for earlier, later in itertools.pairwise(lateness))
    assert error_ns >= 0


def test_virtual_time_has_no_lateness(lab: Lab) -> None:
    assert lab.lateness_ns() == []


def test_a_frame_sent_while_time_passes_starts_then(real: Lab) -> None:
    bus = real.can_bus()
    a, b = bus.node("a"), bus.node("b")
    real.run_for(0.003)
    before_ns = real.now_ns
    a.send(C04)
    frame = b.receive(timeout=AGES)
    assert frame is not None
    assert frame.timestamp_ns >= before_ns + 62 * 2000


def test_an_exception_in_a_callback_surfaces() -> None:
    def broken() -> None:
        raise RuntimeError("mine")

    lab = Lab(time="real")
    lab.at(lab.now_ns + 1_000_000, broken)
    with pytest.raises(RuntimeError, match="mine"):
        lab.run_for(AGES)
    with pytest.raises(RuntimeError, match="mine"):
        lab.close()
    lab.close()


def test_closing_ends_the_thread() -> None:
    lab = Lab(time="real")
    lab.can_bus().node("a", Ticker())
    lab.run_for(0.006)
    assert lab.pacer is not None
    lab.close()
    lab.close()
    assert not lab.pacer._thread.is_alive()


def test_asyncio(real: Lab) -> None:
    bus = real.can_bus()
    a, b = bus.node("a"), bus.node("b")

    async def main() -> tuple[int, Frame | None]:
        receiving = asyncio.ensure_future(b.receive_async(timeout=AGES))
        end_ns = await a.send_async(C04)
        return end_ns, await receiving

    end_ns, frame = asyncio.run(main())
    assert frame is not None
    assert (frame, frame.timestamp_ns) == (C04, end_ns)


class LateWaiters(dict["asyncio.Future[None]", int]):
    """Of a lab whose tasks begin to wait only once there is nothing more to wait for."""

    def __init__(self, over: Callable[[], bool]) -> None:
        self.over = over

    def __setitem__(self, waiter: asyncio.Future[None], deadline_ns: int) -> None:
        while not self.over():
            pass
        super().__setitem__(waiter, deadline_ns)


@pytest.mark.parametrize("waits", ["send", "receive"])
def test_asyncio_hears_of_what_happens_before_it_waits(real: Lab, waits: str) -> None:
    """The buses run meanwhile, in another thread."""
    bus = real.can_bus(bit_rate=10_000)  # 6.2 ms a frame
    a, b = bus.node("a"), bus.node("b")
    real.waiters = LateWaiters(lambda: (a.delivered, b.waiting) == (1, 1))

    async def main() -> None:
        if waits == "send":
            await a.send_async(C04)
        else:
            a.send(C04)
            assert await b.receive_async() == C04

    asyncio.run(asyncio.wait_for(main(), AGES))


def test_asyncio_hears_of_bus_off(real: Lab) -> None:
    bus = real.can_bus()
    a, _ = bus.node("a"), bus.node("b")
    bus.faults.flip(bit="dlc", times=32, seen_by="sender")
    with pytest.raises(BusOff, match="can0/a: bus-off"):
        asyncio.run(asyncio.wait_for(a.send_async(C04), AGES))


def test_asyncio_timeout(real: Lab) -> None:
    b = real.can_bus().node("b")
    before_ns = real.now_ns
    assert asyncio.run(b.receive_async(timeout=0.01)) is None
    assert real.now_ns - before_ns >= 9_000_000


def test_faults_in_the_middle_of_things(real: Lab) -> None:
    bus = real.can_bus(bit_rate=50_000)
    a, b = bus.node("a"), bus.node("b")
    a.send_many([Frame(k, bytes(8)) for k in range(5)])
    assert b.receive(timeout=AGES) is not None
    bus.faults.disconnect(b)
    real.run_for(0.002)
    bus.faults.reconnect(b)
    bus.faults.short()
    bus.faults.clear_short()
    real.run_until_idle()
    assert (a.pending, a.sent) == (0, 5)


def test_closing_does_not_take_nodes_away_from_scripts_that_run() -> None:
    """The timer that is due while the lab closes is the last one, and finds everything there."""
    lab = Lab(time="real")
    node = lab.can_bus().node("a")
    begun, going_on = threading.Event(), threading.Event()
    sent: list[bool] = []

    def turn() -> None:
        begun.set()
        assert going_on.wait(AGES)
        node.send(C04)
        sent.append(True)

    def end() -> None:
        going_on.set()
        close()

    assert lab.pacer is not None
    close, lab.pacer.close = lab.pacer.close, end  # type: ignore[method-assign]
    lab.at(0, turn)
    assert begun.wait(AGES)
    lab.close()
    assert sent == [True]
