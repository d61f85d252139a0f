"""The bench with asyncio, in virtual time: waiting tasks let time pass, and cancelling one loses nothing.

Wall-clock limits here only keep a broken build from hanging; nothing is measured by them.
"""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from typing import Any, TypeVar

import pytest

from canwire import BusOff, Closed, ErrorState, Frame, Lab, LabBus, LabNode, NotTransmitted

pytestmark = [pytest.mark.core, pytest.mark.conforms("PL-03")]

C04 = Frame(0x123, b"\x11\x22")  # 62 bits of 2 us
C04_NS = 62 * 2000
C08 = Frame(0x2AA, b"\xaa" * 8)
C08_NS = 108 * 2000
GAP_NS = 3 * 2000
AGES = 60.0  # seconds of wall clock


T = TypeVar("T")


def run(main: Coroutine[Any, Any, T]) -> T:
    async def bounded() -> T:
        return await asyncio.wait_for(main, AGES)

    return asyncio.run(bounded())


def test_async_for_gives_every_frame_in_order(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send_many(Frame(k) for k in range(20))

    async def main() -> list[int]:
        got = []
        async for frame in b:
            got.append(frame.id)
            if len(got) == 20:
                return got
        return got

    assert run(main()) == list(range(20))
    assert lab.now_ns == b.line.timeline.now_ns
    assert (b.waiting, a.delivered) == (0, 20)


def test_a_frame_is_given_at_its_time(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send_many([C04, C08])

    async def main() -> list[tuple[Frame | None, int]]:
        return [(await b.receive_async(), lab.now_ns) for _ in range(2)]

    assert run(main()) == [(C04, C04_NS), (C08, C04_NS + GAP_NS + C08_NS)]


def test_send_async_returns_when_the_frame_was_over(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")

    async def main() -> list[int]:
        return [await a.send_async(C04), await a.send_async(C08)]

    assert run(main()) == [C04_NS, C04_NS + GAP_NS + C08_NS]
    assert [frame.timestamp_ns for frame in b.receive_many(9)] == [C04_NS, C04_NS + GAP_NS + C08_NS]


def test_send_async_of_several_at_once(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")

    async def main() -> list[int]:
        return await asyncio.gather(*[a.send_async(C08) for _ in range(5)])

    ends = run(main())
    assert ends == [frame.timestamp_ns for frame in b.receive_many(9)]
    assert ends == sorted(ends)


def test_high_priority_and_normal_frames_each_get_their_own_answer(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    b.send(Frame(0x000, bytes(8)))

    async def main() -> list[int]:
        lab.run_for(0.000_02)
        return await asyncio.gather(
            a.send_async(Frame(0x100)), a.send_async(Frame(0x200), high_priority=True)
        )

    ends = run(main())
    stamps = {frame.id: frame.timestamp_ns for frame in b.receive_many(9)}
    assert ends == [stamps[0x100], stamps[0x200]]
    assert ends[1] < ends[0]


def test_single_shot_that_lost_arbitration_raises(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")

    async def main() -> tuple[object, ...]:
        loser = a.send_async(Frame(0x200), single_shot=True)
        winner = b.send_async(Frame(0x100))
        return tuple(await asyncio.gather(loser, winner, return_exceptions=True))

    lost, won = run(main())
    assert isinstance(lost, NotTransmitted)
    assert "0x200" in str(lost)
    assert "can0/a" in str(lost)
    assert isinstance(won, int)
    assert (a.aborted, a.pending) == (1, 0)


def test_single_shot_with_an_error_raises(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    can_bus.faults.inject("bit")

    async def main() -> int:
        with pytest.raises(NotTransmitted):
            await a.send_async(C04, single_shot=True)
        return await a.send_async(C08)

    end_ns = run(main())
    assert [(frame.id, frame.timestamp_ns) for frame in b.receive_many(9)] == [(C08.id, end_ns)]


def test_bus_off_raises(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    can_bus.faults.flip(bit="dlc", times=32, seen_by="sender")

    async def main() -> None:
        with pytest.raises(BusOff, match="can0/a: bus-off; restart it"):
            await a.send_async(C04)
        assert a.state is ErrorState.BUS_OFF
        a.restart()
        frame = await b.receive_async()  # it stayed queued
        assert frame == C04
        # and answers still go to whom they belong
        end_ns = await a.send_async(C08)
        frame = await b.receive_async()
        assert frame is not None
        assert (frame, frame.timestamp_ns) == (C08, end_ns)

    run(main())


def test_bus_off_raises_where_the_loop_lets_time_pass(lab: Lab, can_bus: LabBus) -> None:
    a, _ = can_bus.node("a"), can_bus.node("b")
    can_bus.faults.flip(bit="dlc", times=32, seen_by="sender")
    with pytest.raises(BusOff, match="can0/a: bus-off"):
        lab.run(a.send_async(C04))


def test_a_node_that_is_closed_ends_who_sends(can_bus: LabBus) -> None:
    a, _ = can_bus.node("a"), can_bus.node("b")

    async def main() -> None:
        sending = asyncio.ensure_future(a.send_async(C04))
        await asyncio.sleep(0)
        a.close()
        await sending

    with pytest.raises(Closed, match="node a is closed"):
        run(main())


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_closed_loop_with_a_task_that_waits_disturbs_nobody(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    loop = asyncio.new_event_loop()
    waiting = loop.create_task(b.receive_async())
    loop.run_until_complete(asyncio.sleep(0.001))
    loop.close()
    a.send(C04)
    assert (b.receive(timeout=1.0), lab.waiters, waiting.done()) == (C04, {}, False)


def test_cancelled_frames_raise_whether_in_the_controller_or_in_the_queue(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")

    async def main() -> list[object]:
        tasks = [asyncio.ensure_future(a.send_async(Frame(0x100 + k))) for k in range(4)]
        while a.pending < 4:
            await asyncio.sleep(0)
        assert a.cancel() > 0
        _done, waiting = await asyncio.wait(tasks, timeout=AGES / 10)
        for task in waiting:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        assert not waiting, f"{len(waiting)} senders never heard of their frames"
        return [task.exception() or task.result() for task in tasks]

    outcomes = run(main())
    lab.run_until_idle()
    received = b.waiting
    assert [isinstance(outcome, NotTransmitted) for outcome in outcomes].count(True) == 4 - received

    async def again() -> None:
        end_ns = await a.send_async(C08)
        assert b.receive_many(99)[-1].timestamp_ns == end_ns

    run(again())


# timeouts and cancelling


def test_a_timeout_passes_in_virtual_time(lab: Lab, can_bus: LabBus) -> None:
    b = can_bus.node("b")

    async def main() -> Frame | None:
        return await b.receive_async(timeout=3600.0)

    assert run(main()) is None
    assert lab.now_ns == 3600 * 10**9


def test_a_frame_before_the_timeout(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    lab.at(5_000_000, lambda: a.send(C04))

    async def main() -> list[Frame | None]:
        return [await b.receive_async(timeout=0.001), await b.receive_async(timeout=0.1)]

    assert run(main()) == [None, C04]
    assert lab.now_ns == 5_000_000 + C04_NS


def test_each_of_several_timeouts_is_over_at_its_own_time(lab: Lab, can_bus: LabBus) -> None:
    nodes = [can_bus.node(name) for name in "abc"]

    async def wait(node: LabNode, seconds: float) -> int:
        assert await node.receive_async(timeout=seconds) is None
        return lab.now_ns

    async def main() -> list[int]:
        waits = [wait(node, seconds) for node, seconds in zip(nodes, (0.010, 0.005, 0.020), strict=True)]
        return await asyncio.gather(*waits)

    assert run(main()) == [10_000_000, 5_000_000, 20_000_000]


def test_a_cancelled_receiver_takes_nothing(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")

    async def main() -> list[Frame | None]:
        waiting = asyncio.ensure_future(b.receive_async())
        for _ in range(10):
            await asyncio.sleep(0)
        waiting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await waiting
        a.send_many([C04, C08])
        return [await b.receive_async(), await b.receive_async()]

    assert run(main()) == [C04, C08]
    assert (b.accepted, b.waiting) == (2, 0)


def test_wait_for_around_a_receiver(lab: Lab, can_bus: LabBus) -> None:
    """asyncio's own timeout is the wall clock's; on a quiet bus it is all that ends the wait."""
    a, b = can_bus.node("a"), can_bus.node("b")

    async def main() -> Frame | None:
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(b.receive_async(), 0.001)
        a.send(C04)
        return await asyncio.wait_for(b.receive_async(), AGES)

    assert run(main()) == C04


@pytest.mark.parametrize("turns", range(12))
def test_cancelling_at_any_point_loses_no_frame(lab: Lab, can_bus: LabBus, turns: int) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    got: list[int] = []

    async def reader() -> None:
        while True:
            frame = await b.receive_async()
            assert frame is not None
            got.append(frame.id)

    async def main() -> None:
        a.send_many(Frame(k) for k in range(30))
        for _ in range(8):
            task = asyncio.ensure_future(reader())
            for _ in range(turns):
                await asyncio.sleep(0)
            task.cancel()
            with pytest.raises(asyncio.CancelledError):
                await task
        lab.run_until_idle()
        got.extend(frame.id for frame in b.receive_many(99))

    run(main())
    assert got == list(range(30))
    assert b.lost == 0


def test_a_cancelled_sender_leaves_its_frame_queued(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")

    async def main() -> int:
        b.send(Frame(0x000, bytes(8)))
        lab.run_for(0.000_02)  # the bus is busy
        sending = asyncio.ensure_future(a.send_async(C04))
        await asyncio.sleep(0)
        sending.cancel()
        with pytest.raises(asyncio.CancelledError):
            await sending
        return await a.send_async(C08)

    end_ns = run(main())
    assert [frame.id for frame in b.receive_many(9)] == [C04.id, C08.id]
    assert end_ns == lab.now_ns
    assert (a.sent, a.delivered) == (2, 2)


def test_closing_ends_the_loop_of_a_waiting_task(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    got: list[Frame] = []

    async def reader() -> None:
        async for frame in b:
            got.append(frame)

    async def main() -> None:
        task = asyncio.ensure_future(reader())
        a.send(C04)
        while not got:
            await asyncio.sleep(0)
        b.close()
        done, _ = await asyncio.wait([task], timeout=AGES / 10)
        assert done, "the reader still waits for a node that is closed"
        assert isinstance(task.exception(), Closed | None)

    run(main())
    assert got == [C04]


def test_using_a_closed_node(lab: Lab, can_bus: LabBus) -> None:
    a = can_bus.node("a")
    a.close()

    async def main() -> None:
        with pytest.raises(Closed):
            await a.send_async(C04)
        with pytest.raises(Closed):
            await a.receive_async()
        assert [frame async for frame in a] == []

    run(main())


# several tasks


async def ping(node: LabNode, rounds: int) -> list[int]:
    times = []
    for k in range(rounds):
        await node.send_async(Frame(0x100, bytes([k])))
        answer = await node.receive_async(timeout=1.0)
        assert answer == Frame(0x200, bytes([k]))
        times.append(answer.timestamp_ns)
    return times


async def pong(node: LabNode, rounds: int) -> None:
    for _ in range(rounds):
        frame = await node.receive_async(timeout=1.0)
        assert frame is not None
        await node.send_async(Frame(0x200, frame.data))


def conversation() -> tuple[list[int], list[str]]:
    with Lab() as lab:
        bus = lab.can_bus()
        a, b = bus.node("a", filters=[(0x200, 0x7FF)]), bus.node("b", filters=[(0x100, 0x7FF)])
        logger = bus.node("logger")

        async def main() -> list[int]:
            return (await asyncio.gather(ping(a, 20), pong(b, 20)))[0]

        return run(main()), [repr(frame) for frame in logger.receive_many(999)]


@pytest.mark.conforms("PL-03", "G-17")
def test_tasks_answer_each_other_and_always_alike() -> None:
    times, log = conversation()
    assert len(log) == 40
    assert log[:2] == [
        'Frame(0x100, bytes.fromhex("00"), timestamp_ns=' + f"{int(log[0].split('=')[1][:-1])})",
        'Frame(0x200, bytes.fromhex("00"), timestamp_ns=' + f"{times[0]})",
    ]
    assert conversation() == (times, log)


def test_many_tasks_on_many_nodes(lab: Lab) -> None:
    bus = lab.can_bus(bit_rate=1_000_000)
    nodes = [bus.node(f"n{k}") for k in range(6)]
    got: dict[str, list[int]] = {node.name: [] for node in nodes}

    async def sender(node: LabNode, number: int) -> None:
        for k in range(10):
            await node.send_async(Frame(k << 4 | number))

    async def receiver(node: LabNode) -> None:
        while len(got[node.name]) < 50:
            frame = await node.receive_async()
            assert frame is not None
            got[node.name].append(frame.id)

    async def main() -> None:
        tasks = [sender(node, k) for k, node in enumerate(nodes)] + [receiver(node) for node in nodes]
        await asyncio.gather(*tasks)

    run(main())
    everything = {k << 4 | number for k in range(10) for number in range(6)}
    for number, node in enumerate(nodes):
        own = {k << 4 | number for k in range(10)}
        assert sorted(got[node.name]) == sorted(everything - own)
    assert all(node.delivered == 10 and node.waiting == 0 for node in nodes)


def test_two_readers_of_one_node_share_its_frames(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    got: list[int] = []

    async def reader() -> None:
        while len(got) < 20:
            frame = await b.receive_async(timeout=0.05)
            if frame is not None:
                got.append(frame.id)

    async def main() -> None:
        a.send_many(Frame(k) for k in range(20))
        await asyncio.gather(reader(), reader())

    run(main())
    assert got == list(range(20))


def test_a_task_s_error_reaches_its_owner(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")

    async def main() -> None:
        a.send(C04)
        async for frame in b:
            raise RuntimeError(f"cannot use {frame.id:#x}")

    with pytest.raises(RuntimeError, match="cannot use 0x123"):
        run(main())
