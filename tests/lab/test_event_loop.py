"""asyncio's own time is the lab's: sleeping, timeouts and the loop's clock, beside nodes that wait for frames."""

from __future__ import annotations

import asyncio
import threading
from pathlib import Path

import pytest

from canwire import BadValue, Closed, Frame, Lab, LabBus, NodeScript
from canwire.held_time import HeldTime
from canwire.lab.event_loop import run
from canwire.timeline import Timeline

pytestmark = [pytest.mark.conforms("PL-03"), pytest.mark.finding("newcomer F12")]

FRAME_NS = 124_000  # Frame(0x123, 11 22) at 500 kbit/s


def test_sleep_lets_the_lab_s_time_pass(lab: Lab) -> None:
    async def main() -> list[int]:
        seen = []
        for seconds in (0.0, 1.5, 3600):
            await lab.sleep(seconds)
            seen.append(lab.now_ns)
        return seen

    assert asyncio.run(main()) == [0, 1_500_000_000, 3_601_500_000_000]


def test_sleepers_wake_in_the_order_of_their_times(lab: Lab) -> None:
    woken: list[tuple[str, int]] = []

    async def sleeper(name: str, seconds: float) -> None:
        await lab.sleep(seconds)
        woken.append((name, lab.now_ns))

    async def main() -> None:
        await asyncio.gather(sleeper("late", 0.3), sleeper("early", 0.1), sleeper("middle", 0.2))

    asyncio.run(main())
    assert woken == [("early", 100_000_000), ("middle", 200_000_000), ("late", 300_000_000)]


def test_sleep_refuses_what_is_no_time(lab: Lab) -> None:
    with pytest.raises(BadValue, match="seconds -1"):
        asyncio.run(lab.sleep(-1))


def test_asyncio_s_own_sleep_takes_virtual_time(lab: Lab) -> None:
    async def main() -> tuple[int, float]:
        await asyncio.sleep(3600)
        return lab.now_ns, asyncio.get_running_loop().time()

    assert lab.run(main()) == (3_600_000_000_000, 3600.0)
    assert lab.now_ns == 3_600_000_000_000


@pytest.mark.parametrize("delay_ns", [1, 3, 124_001, 999_999_999, 86_400_000_000_001])
def test_a_sleep_is_exact_to_the_nanosecond(lab: Lab, delay_ns: int) -> None:
    async def main() -> None:
        await asyncio.sleep(delay_ns / 1e9)

    lab.run(main())
    assert lab.now_ns == delay_ns


def test_a_timeout_of_asyncio_comes_in_virtual_time(lab: Lab, can_bus: LabBus) -> None:
    node = can_bus.node("a")

    async def main() -> int:
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(node.receive_async(), 2.5)
        return lab.now_ns

    assert lab.run(main()) == 2_500_000_000


def test_frames_come_at_their_times_while_others_sleep(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    seen: list[tuple[object, int]] = []

    async def send() -> None:
        for _ in range(3):
            await asyncio.sleep(1.0)
            a.send(Frame(0x123, b"\x11\x22"))

    async def receive() -> None:
        for _ in range(3):
            seen.append((await b.receive_async(), lab.now_ns))
        seen.append((await b.receive_async(timeout=0.25), lab.now_ns))

    async def main() -> None:
        await asyncio.gather(send(), receive())

    lab.run(main())
    frame = Frame(0x123, b"\x11\x22")
    at = [k * 1_000_000_000 + FRAME_NS for k in (1, 2, 3)]
    assert seen == [*((frame, time_ns) for time_ns in at), (None, at[-1] + 250_000_000)]


def test_scripts_go_on_while_tasks_sleep(lab: Lab, can_bus: LabBus) -> None:
    class Clock(NodeScript):
        def on_start(self) -> None:
            self.every(0.1, lambda: self.send(Frame(1)))

    can_bus.node("clock", Clock())
    listener = can_bus.node("listener")

    async def main() -> int:
        await asyncio.sleep(1.05)
        return listener.waiting

    assert lab.run(main()) == 10


def test_what_another_thread_brings_wakes_a_lab_where_nothing_happens(lab: Lab) -> None:
    async def main() -> str:
        return await asyncio.to_thread(lambda: "from a thread")

    assert lab.run(main()) == "from a thread"


def test_threads_that_end_late_take_no_time_of_the_lab() -> None:
    timeline, late = Timeline(), threading.Event()

    async def main() -> None:
        loop = asyncio.get_running_loop()
        waiting = loop.run_in_executor(None, late.wait)
        await loop.shutdown_default_executor(300)  # as asyncio.Runner does from Python 3.12 on
        assert await waiting

    run(timeline, HeldTime(), main(), late.set)
    assert timeline.now_ns == 0


def test_the_same_every_time(tmp_path: Path) -> None:
    def once() -> list[tuple[str, int]]:
        log: list[tuple[str, int]] = []
        with Lab() as lab:
            bus = lab.can_bus()
            nodes = [bus.node(name) for name in "abc"]

            async def chat(number: int) -> None:
                for k in range(5):
                    await nodes[number].send_async(Frame(0x100 * number + k))
                    log.append((f"{number}.{k}", lab.now_ns))
                    await asyncio.sleep(0.0001 * number)

            async def main() -> None:
                await asyncio.gather(*(chat(number) for number in range(3)))

            lab.run(main())
        return log

    first = once()
    assert len(first) == 15
    assert once() == first


def test_a_closed_lab_runs_nothing() -> None:
    lab = Lab()
    lab.close()
    pause = asyncio.sleep(0)
    with pytest.raises(Closed):
        lab.run(pause)
    pause.close()


@pytest.mark.realtime
def test_in_real_time_it_is_asyncio_run() -> None:
    with Lab(time="real") as lab:

        async def main() -> int:
            before_ns = lab.now_ns
            await asyncio.sleep(0.01)
            await lab.sleep(0.01)
            return lab.now_ns - before_ns

        assert lab.run(main()) >= 20_000_000
