"""One time for many: threads of this process that keep it together, on a hub in it. Processes: tests/lockstep/."""

from __future__ import annotations

import asyncio
import queue
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager

import pytest

import canwire
from canwire.boards.config.configuration import Config
from canwire.hub.handles.hub import Hub
from canwire.hub.links.local import LocalLink
from canwire.hub.links.network.client import NetworkLink
from canwire.hub.links.network.session.settings import Patience
from canwire.hub.owner.engine import LOCKSTEP, Engine
from canwire.hub.owner.entrance import open_session
from canwire.hub.owner.lockstep import keeper
from canwire.hub.owner.lockstep.pace import LockstepPace
from canwire.hub.owner.lockstep.turns import Turns
from canwire.hub.owner.world import World
from canwire.hub.protocol.messages import JoinTime
from canwire.platform import PORTABLE
from tests.hubs import LONG_S, free_port

BY_PAGE, BY_MESSAGES, BY_NETWORK = "by a page", "by messages", "over the network"
FRAME = canwire.Frame(0x123, b"\x01")


class Stage:
    """A hub whose time begins with `expected` threads, and what it said."""

    def __init__(self, expected: int, patience_s: float) -> None:
        world = World(Config.default(), turns=Turns(expected))
        self.said: queue.Queue[str] = queue.Queue()
        world.warn = self.said.put
        self.engine = Engine(world, LOCKSTEP, LockstepPace(world, patience_s))
        self.log: list[tuple[int, str]] = []
        self.closing = ExitStack()
        self.closing.callback(self.engine.close)
        self._network = ""
        self._ended: list[tuple[threading.Thread, list[BaseException]]] = []

    def connect(self, name: str, *, timed: bool = True, way: str = BY_PAGE) -> canwire.Hub:
        if way == BY_NETWORK:
            hub = Hub(NetworkLink(self._network, name))
        else:
            link = LocalLink(self.engine, name)
            link._session.shares_memory = way == BY_PAGE
            hub = Hub(link)
        if timed:
            hub.keep_time(name)
        return hub

    def offer(self) -> None:
        """To other machines."""
        from canwire.hub.links.network.bridge import Bridge
        from canwire.hub.links.network.offered import Offered

        place = f"tcp/127.0.0.1:{free_port()}"
        offered = Offered(realm="tests", name="stage", listen=(place,))
        bridge = Bridge(lambda name: LocalLink(self.engine, name), offered, lambda: None)
        self.closing.callback(bridge.close)
        self._network = f"zenoh://tests/stage?via={place}"

    def program(self, name: str, work: Callable[[canwire.Hub], object], **options: str) -> None:
        """A thread that connects by this name and does this."""
        failed: list[BaseException] = []

        def run() -> None:
            try:
                with self.connect(name, **options) as hub:
                    work(hub)
            except BaseException as error:
                failed.append(error)

        thread = threading.Thread(target=run, daemon=True)
        self._ended.append((thread, failed))
        thread.start()

    def hears(self, what: str) -> str:
        """What the hub says with these words, after anything else: on a busy machine all that is slow computes."""
        while what not in (said := self.said.get(timeout=LONG_S)):
            pass
        return said

    def at(self, hub: canwire.Hub, what: str) -> None:
        self.log.append((hub.now_ns(), what))

    def end(self) -> list[tuple[int, str]]:
        """What was logged once all have ended, each without an error."""
        for thread, failed in self._ended:
            thread.join(LONG_S)
            assert not thread.is_alive(), (self.log, list(self.said.queue))
            for error in failed:
                raise error
        return self.log


@contextmanager
def stage(expected: int, patience_s: float = 5.0, way: str = BY_PAGE) -> Iterator[Stage]:
    made = Stage(expected, patience_s)
    with made.closing:
        if way == BY_NETWORK:
            made.offer()
        yield made


@pytest.fixture(
    params=[
        BY_PAGE,
        BY_MESSAGES,
        pytest.param(BY_NETWORK, marks=pytest.mark.skipif(PORTABLE, reason="needs Linux' own platform")),
    ]
)
def way(request: pytest.FixtureRequest) -> str:
    if request.param == BY_NETWORK:
        pytest.importorskip("zenoh")
    return str(request.param)


def line_of(hub: canwire.Hub, number: int) -> tuple[int, int]:
    place = canwire.find_lines(hub, "can0")[number]
    return place.board.id, place.line


def bring_up(hub: canwire.Hub, stack: ExitStack, number: int) -> canwire.HubChannel:
    board, line = line_of(hub, number)
    control = stack.enter_context(hub.open_control(board, line))
    timing = canwire.BitTiming.for_bit_rate(500_000, clock_hz=80_000_000)
    control.initialise(canwire.LineMode(timing))
    channel = stack.enter_context(hub.open_channel(board, line))
    channel.set_up(canwire.ChannelMode(100, 100))
    channel.activate()
    control.start()
    return channel


@pytest.mark.skipif(PORTABLE, reason="needs Linux' own platform")
def test_a_hub_that_is_silent_for_a_while_ends_no_program_that_keeps_its_time() -> None:
    pytest.importorskip("zenoh")
    with stage(2, way=BY_NETWORK) as made:
        silent = threading.Event()
        made.program("a", lambda hub: silent.wait(LONG_S))  # its turn comes first, and it computes
        link = NetworkLink(made._network, "b", patience=Patience(call_s=LONG_S))
        link._patience = Patience(call_s=0.05)
        hears = link._asker._heard_since

        def looks(began_s: float, silence_s: float) -> None:
            hears(began_s, silence_s)
            if time.monotonic() - max(began_s, link._pump.heard_ns / 1e9) > link._patience.call_s:
                silent.set()

        link._asker._heard_since = looks  # type: ignore[method-assign]
        with Hub(link) as hub:
            hub.keep_time("b")
            assert silent.is_set()
            link._patience = Patience(call_s=LONG_S)
            assert hub.now_ns() == 0
        made.end()


@pytest.mark.smoke
@pytest.mark.conforms("G-17")
@pytest.mark.parametrize("run", range(3))
def test_turns_go_by_name_at_each_instant(run: int, way: str) -> None:
    with stage(3, way=way) as made:

        def work(name: str, period_s: float) -> Callable[[canwire.Hub], None]:
            def steps(hub: canwire.Hub) -> None:
                for _ in range(3):
                    made.at(hub, name)
                    hub.sleep(period_s)

            return steps

        for name, period_s in (("c", 0.001), ("a", 0.002), ("b", 0.001)):
            made.program(name, work(name, period_s), way=way)
        assert made.end() == [
            (0, "a"), (0, "b"), (0, "c"), (1_000_000, "b"), (1_000_000, "c"), (2_000_000, "a"), (2_000_000, "b"),
            (2_000_000, "c"), (4_000_000, "a"),
        ]  # fmt: skip


def test_frames_wake_their_reader_at_the_instant_they_come(way: str) -> None:
    with stage(2, way=way) as made:

        def reader(hub: canwire.Hub) -> None:
            with ExitStack() as stack:
                channel = bring_up(hub, stack, 0)
                hub.sleep(0.001)
                for _ in range(2):
                    frame = channel.receive(timeout=0.01)
                    made.at(hub, "nothing" if frame is None else f"{frame.id:X} of {frame.timestamp_ns}")

        def sender(hub: canwire.Hub) -> None:
            with ExitStack() as stack:
                channel = bring_up(hub, stack, 1)
                hub.sleep(0.002)
                channel.send(FRAME)
                hub.sleep(0.1)

        made.program("reader", reader, way=way)
        made.program("sender", sender, way=way)
        (first_ns, heard), nothing = made.end()
        assert heard == f"123 of {first_ns}"
        assert 2_100_000 < first_ns < 2_130_000
        assert nothing == (first_ns + 10_000_000, "nothing")


def test_an_event_set_by_another_thread_of_the_program(way: str) -> None:
    with stage(2, way=way) as made, closing(canwire.Event()) as event:
        ready: list[canwire.Hub] = []

        def waiter(hub: canwire.Hub) -> None:
            with ExitStack() as stack:
                board, line = line_of(hub, 0)
                channel = stack.enter_context(hub.open_channel(board, line))
                channel.set_up(canwire.ChannelMode(10, 0))
                channel.reading.assign(event)
                ready.append(hub)
                assert event.wait(5.0)
                made.at(hub, "set")
                assert not event.wait(0.25)
                made.at(hub, "not set again")

        def setter(hub: canwire.Hub) -> None:
            hub.sleep(1.5)
            event.set()
            ready[0].create_luid()  # behind the signal, which goes by the waiter's connection
            hub.sleep(0.1)

        made.program("b waiter", waiter, way=way)
        made.program("a setter", setter, way=way)
        assert made.end() == [(1_500_000_000, "set"), (1_750_000_000, "not set again")]


def test_a_fifo_between_programs_wakes_its_reader(way: str) -> None:
    with stage(2, way=way) as made:
        numbers: list[int] = []

        def reader(hub: canwire.Hub) -> None:
            fifo = hub.create_fifo(4, 1)
            numbers.append(fifo.id)
            with hub.open_fifo(fifo.id, "reader") as end:
                assert end.end_of_ring.wait(10.0)
                made.at(hub, str(end.end_of_ring.ring.take_bytes()))

        def writer(hub: canwire.Hub) -> None:
            hub.sleep(1.0)
            with hub.open_fifo(numbers[0], "writer") as end:
                end.end_of_ring.ring.put_bytes(b"x")
                hub.sleep(1.0)

        made.program("1 reader", reader, way=way)
        made.program("2 writer", writer, way=way)
        assert made.end() == [(1_000_000_000, "b'x'")]


def test_a_thread_that_ends_is_not_waited_for_and_one_that_is_away_neither(way: str) -> None:
    with stage(1, way=way) as made:

        def main(hub: canwire.Hub) -> None:
            def helper() -> None:
                hub.sleep(2.0)
                made.at(hub, "helper")

            thread = threading.Thread(target=helper)
            with hub.away():
                thread.start()
                thread.join()
            made.at(hub, "joined")
            hub.sleep(1.0)
            made.at(hub, "main")

        made.program("main", main, way=way)
        assert made.end() == [(2_000_000_000, "helper"), (2_000_000_000, "joined"), (3_000_000_000, "main")]


def test_who_looks_on_holds_nobody_up_and_has_the_time() -> None:
    with stage(1) as made:
        viewer = made.connect("viewer", timed=False)
        made.program("a", lambda hub: hub.sleep(3600.0))
        made.end()
        assert (viewer.timed, viewer.virtual, viewer.now_ns()) == (False, False, 3_600_000_000_000)
        assert viewer.time_state().programs == ()
        made.hears("a (")
        viewer.close()


def test_who_computes_for_too_long_is_named_and_time_waits_on() -> None:
    go_on = threading.Event()
    with stage(2, patience_s=0.05) as made:
        viewer = made.connect("viewer", timed=False)

        def busy(hub: canwire.Hub) -> None:
            hub.sleep(0.5)
            assert go_on.wait(LONG_S)
            made.at(hub, "busy")

        made.program("busy", busy)
        made.program("idle", lambda hub: hub.sleep(1.0))
        said = made.hears("time stopped at 0.500000000 s: busy (")
        assert "computes" in said
        state = viewer.time_state()
        assert (state.now_ns, state.standstill) == (500_000_000, said)
        assert [(one.name.split()[0], one.waits, one.until_ns) for one in state.programs] == [
            ("busy", False, None),
            ("idle", True, 1_000_000_000),
        ]
        go_on.set()
        assert made.end() == [(500_000_000, "busy")]
        viewer.close()


def test_a_loop_without_time_is_named_and_so_is_a_wait_for_ever() -> None:
    over = threading.Event()
    with stage(1, patience_s=0.05) as made:

        def polls(hub: canwire.Hub) -> None:
            while not over.is_set():
                hub.sleep(0)

        made.program("polls", polls)
        assert "polls (" in made.hears("again and again")
        over.set()
        made.end()
    with stage(1, patience_s=0.05) as made:

        def waits(hub: canwire.Hub) -> None:
            with ExitStack() as stack, pytest.raises(canwire.HubLost):
                bring_up(hub, stack, 0).receive(timeout=None)

        made.program("waits", waits)
        made.hears("everybody waits without a timeout")
        made.engine.close()
        made.end()


def test_only_a_hub_in_lockstep_keeps_one_time(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(canwire.WrongState, match="--time lockstep"):
        canwire.connect(time="virtual", timed=True)
    monkeypatch.setenv("CANWIRE_TIMED", "perhaps")
    with pytest.raises(canwire.BadValue, match="CANWIRE_TIMED='perhaps'"):
        canwire.connect()
    monkeypatch.setenv("CANWIRE_TIMED", "1")
    with canwire.connect(time="virtual") as hub:  # its own, which nobody else is on
        assert not hub.timed


def test_a_program_alone_has_its_own_time() -> None:
    with canwire.connect(time="lockstep", timed=True, name="me") as hub:
        hub.sleep(10.0)
        assert (hub.now_ns(), hub.clock_s(), hub.time) == (10_000_000_000, 10.0, "lockstep")
        with hub.away():
            pass
        hub.run_for(1.0)
        assert hub.now_ns() == 11_000_000_000
        assert repr(hub) == "<hub in this process, lockstep time>"


def test_a_second_connection_of_a_thread_that_runs_has_its_turn() -> None:
    with stage(1) as made:

        def both(hub: canwire.Hub) -> None:
            with made.connect("another") as other:
                hub.sleep(1.0)
                made.at(other, "other")
                other.sleep(1.0)
                made.at(hub, "first")
            hub.sleep(1.0)
            made.at(hub, "after")

        made.program("one", both)
        assert made.end() == [(10**9, "other"), (2 * 10**9, "first"), (3 * 10**9, "after")]


def test_asyncio_waits_by_the_hubs_time(way: str) -> None:
    with stage(2, way=way) as made:

        async def tasks(hub: canwire.Hub, channel: canwire.HubChannel, event: canwire.Event) -> None:
            heard = asyncio.Event()

            def arrived() -> None:
                event.reset()
                heard.set()

            asyncio.get_running_loop().add_reader(event.fileno(), arrived)
            await asyncio.gather(asyncio.wait_for(heard.wait(), 1.0), asyncio.sleep(0.25))
            made.at(hub, f"{channel.receive()}")
            with pytest.raises(asyncio.TimeoutError):
                await asyncio.wait_for(asyncio.Event().wait(), 0.5)
            made.at(hub, "timeout")

        def reader(hub: canwire.Hub) -> None:
            with ExitStack() as stack, closing(canwire.Event()) as event:
                channel = bring_up(hub, stack, 0)
                channel.reading.assign(event)
                hub.run(tasks(hub, channel, event))

        def sender(hub: canwire.Hub) -> None:
            with ExitStack() as stack:
                channel = bring_up(hub, stack, 1)
                hub.sleep(0.1)
                channel.send(FRAME)
                hub.sleep(2.0)

        made.program("1 reader", reader, way=way)
        made.program("2 sender", sender, way=way)
        heard, timeout = made.end()
        assert heard[0] == 250_000_000
        assert heard[1].startswith("Frame(0x123")
        assert timeout == (750_000_000, "timeout")


@pytest.mark.conforms("G-17")
@pytest.mark.parametrize("run", range(2))
def test_an_answer_that_takes_bus_time_ends_its_programs_turn(run: int, way: str) -> None:
    with stage(2, way=way) as made:

        def stops(hub: canwire.Hub) -> None:
            with ExitStack() as stack:
                hub.sleep(0.001)
                fault = stack.enter_context(hub.bus("can0").faults.flip(bit=20))
                made.at(hub, "waits")
                assert not fault.wait(0.005)
                made.at(hub, "has waited")

        def other(hub: canwire.Hub) -> None:
            hub.sleep(0.002)
            made.at(hub, "other")

        made.program("1 stops", stops, way=way)
        made.program("2 other", other, way=way)
        waits, between, waited = made.end()
        assert (waits[1], between, waited[1]) == ("waits", (2_000_000, "other"), "has waited")
        assert waited[0] == waits[0] + 5_000_000


def test_a_frame_that_comes_meanwhile_is_no_answer(way: str) -> None:
    """An event that is assigned to a queue is signalled while its program waits for something that takes bus time."""
    with stage(2, way=way) as made:

        def waits(hub: canwire.Hub) -> None:
            with ExitStack() as stack, closing(canwire.Event()) as event:
                channel = bring_up(hub, stack, 0)
                hub.sleep(0.001)
                channel.reading.assign(event)
                fault = stack.enter_context(hub.bus("can0").faults.flip(bit=20, frame_id=0x7FF))
                before_ns = hub.now_ns()
                assert fault.wait(0.005) is False
                made.at(hub, f"{hub.now_ns() - before_ns} {channel.receive()}")

        def sends(hub: canwire.Hub) -> None:
            with ExitStack() as stack:
                channel = bring_up(hub, stack, 1)
                hub.sleep(0.002)
                channel.send(FRAME)
                hub.sleep(0.1)

        made.program("1 waits", waits, way=way)
        made.program("2 sends", sends, way=way)
        ((_, what),) = made.end()
        assert what.startswith("5000000 Frame(0x123")


def test_a_queue_overflows_and_a_full_one_has_room_again_at_the_same_moments(way: str) -> None:
    with stage(2, way=way) as made:

        def reader(hub: canwire.Hub) -> None:
            with ExitStack() as stack:
                bring_up(hub, stack, 0)
                board, line = line_of(hub, 0)
                channel = stack.enter_context(hub.open_channel(board, line))
                channel.set_up(canwire.ChannelMode(8, 0, exact=True))
                channel.activate()
                hub.sleep(0.1)
                first = [channel.receive() for _ in range(3)]
                made.at(hub, " ".join(f"{frame.id:X}" for frame in first if frame is not None))
                hub.sleep(0.2)
                rest = channel.receive_many(100)
                made.at(hub, " ".join(f"{frame.id:X}" for frame in rest) + f" lost {channel.status().lost}")

        def sender(hub: canwire.Hub) -> None:
            with ExitStack() as stack:
                bring_up(hub, stack, 1)
                board, line = line_of(hub, 1)
                channel = stack.enter_context(hub.open_channel(board, line))
                channel.set_up(canwire.ChannelMode(1, 4, exact=True))
                channel.activate()
                hub.sleep(0.010)
                for number in range(12):
                    channel.send(canwire.Frame(number, b""), timeout=None)
                made.at(hub, "all are under way")
                hub.sleep(0.2)
                for number in range(6):
                    channel.send(canwire.Frame(0x10 + number, b""), timeout=None)
                hub.sleep(0.2)

        made.program("reader", reader, way=way)
        made.program("sender", sender, way=way)
        (sent_ns, _), *read = made.end()
        assert read == [
            (100_000_000, "0 1 2"),
            (300_000_000, "3 4 5 6 7 10 11 12 lost 7"),
        ]
        assert 10_500_000 < sent_ns < 11_500_000


def test_so_many_threads_of_a_program_take_part_and_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(keeper, "_THREADS", 2)
    world = World(Config.default(), turns=Turns(1))
    assert world.lockstep is not None
    session = open_session(world, "a", 1, lambda _: None, None)
    for thread in (1, 2, 1):
        world.lockstep.join(session, JoinTime("1-a", thread, "a"))
    with pytest.raises(canwire.LimitReached, match="2 of its threads"):
        world.lockstep.join(session, JoinTime("1-a", 3, "a"))
    world.close_session(session)
    assert not world.lockstep.occupied
