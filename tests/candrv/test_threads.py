"""Many threads on one handle, and closing it under them (FS-20, FS-21, FS-22)."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

import canwire
from canwire import Frame, candrv
from canwire.candrv import Handle
from canwire.candrv.constants import CanbusEvent, Win32Error
from canwire.candrv.errors import CandrvError
from canwire.candrv.registry.registry import RegistryStore
from tests.candrv.bench import Bench, Peer
from tests.hubs import Served

LONG = 30


class Threads:
    """Threads whose failures are a test's."""

    def __init__(self) -> None:
        self._threads: list[threading.Thread] = []
        self.errors: list[BaseException] = []

    def start(self, work: Callable[..., object], *arguments: Any) -> None:
        def run() -> None:
            try:
                work(*arguments)
            except BaseException as error:
                self.errors.append(error)

        self._threads.append(threading.Thread(target=run, daemon=True))
        self._threads[-1].start()

    def join(self) -> list[int]:
        """The codes they failed with, in no order."""
        for thread in self._threads:
            thread.join(LONG)
            assert not thread.is_alive(), "a thread hangs"
        others = [error for error in self.errors if not isinstance(error, CandrvError)]
        assert others == []
        return sorted(error.code for error in self.errors if isinstance(error, CandrvError))


def asleep(handle: Handle, count: int) -> None:
    """Until so many threads wait on the handle."""
    end = time.monotonic() + LONG
    while handle._channel.room._waiting < count:
        assert time.monotonic() < end
        time.sleep(0.001)


def timeouts(handle: Handle, read: int, write: int) -> None:
    chosen = handle.timeouts
    chosen.ReadTotalTimeoutConstant, chosen.WriteTotalTimeoutConstant = read, write
    handle.timeouts = chosen


@pytest.mark.conforms("FS-20")
def test_readers_share_the_events_and_lose_none(
    registry: RegistryStore, hub: canwire.Hub, peer: Peer
) -> None:
    registry.set("CID1", "EventQueueSize", 5000)
    count, threads, got = 2000, Threads(), []
    with candrv.open(hub=hub, write=False) as handle:
        handle.accept_all()
        handle.mask = CanbusEvent.RECEIVED

        def read() -> None:
            while (event := handle.read_event()).identifier != 0x7FF:
                got.append(event.data)

        for _ in range(4):
            threads.start(read)
        for n in range(count):
            peer.send(Frame(n % 0x700, n.to_bytes(4, "little")))
        for _ in range(4):
            peer.send(Frame(0x7FF))
        assert threads.join() == []
        assert sorted(int.from_bytes(data, "little") for data in got) == list(range(count))


@pytest.mark.conforms("FS-20")
@pytest.mark.parametrize("mode", [7, 6])
def test_writers_share_a_handle(registry: RegistryStore, hub: canwire.Hub, peer: Peer, mode: int) -> None:
    registry.set("CID1", "TxMode", mode)
    registry.set("CID1", "EventQueueSize", 5000)
    threads, each = Threads(), 100
    with candrv.open(hub=hub) as handle:

        def write(number: int) -> None:
            for n in range(each):
                print(f"{number:x} 0 2 {n:x}", "0", file=handle)  # in three pieces

        for number in range(1, 5):
            threads.start(write, number)
        assert threads.join() == []
        frames = peer.received(4 * each)
        for number in range(1, 5):
            assert [frame.data[0] for frame in frames if frame.id == number] == list(range(each))
        events = [handle.read_event() for _ in range(4 * each)]
        assert {event.event for event in events} == {CanbusEvent.TRANSMITTED}


@pytest.mark.conforms("FS-21")
def test_closing_releases_all_who_wait(hub: canwire.Hub) -> None:
    handle = candrv.open(hub=hub)  # nobody else is on the bus: nothing goes out
    threads = Threads()

    def write() -> None:
        while True:
            handle.write("1 0 0\n")

    handle.mask = CanbusEvent.RECEIVED
    for call in (handle.read_event, handle.read_text, handle.wait_comm_event, write, write):
        threads.start(call)
    asleep(handle, 5)
    handle.close()
    assert threads.join() == [Win32Error.ERROR_OPERATION_ABORTED] * 5


@pytest.mark.conforms("FS-21")
def test_closing_releases_a_writer_in_single_message_mode(registry: RegistryStore, hub: canwire.Hub) -> None:
    registry.set("CID1", "TxMode", 6)
    handle, threads = candrv.open(hub=hub), Threads()
    for _ in range(3):
        threads.start(handle.write, "1 0 0\n")
    asleep(handle, 3)
    handle.close()
    assert threads.join() == [Win32Error.ERROR_OPERATION_ABORTED] * 3


@pytest.mark.conforms("FS-21")
def test_closing_at_any_moment(hub: canwire.Hub, peer: Peer) -> None:
    for turn in range(10):
        handle, threads = candrv.open(hub=hub), Threads()
        handle.accept_all()
        timeouts(handle, 5, 5)

        def read(handle: Handle = handle) -> None:
            while True:
                for _ in handle:
                    pass
                handle.check()

        def write(handle: Handle = handle) -> None:
            while True:
                try:
                    handle.write("1 0 0\n")
                except CandrvError as error:
                    if error.code != Win32Error.ERROR_TIMEOUT:
                        raise

        for work in (read, read, write, write):
            threads.start(work)
        for n in range(20):
            peer.send(Frame(0x100 + n))  # not what the handle sends: two equal frames have no acknowledge
        time.sleep(0.002 * turn)
        handle.close()
        allowed = {Win32Error.ERROR_OPERATION_ABORTED, Win32Error.ERROR_INVALID_HANDLE}
        assert set(threads.join()) <= allowed


def test_timeouts_are_kept_beside_sleeping_threads(hub: canwire.Hub) -> None:
    handle, threads = candrv.open(hub=hub), Threads()
    threads.start(handle.wait_comm_event)
    asleep(handle, 1)
    timeouts(handle, 50, 50)
    began = time.monotonic()
    with pytest.raises(CandrvError) as raised:
        handle.read_event()
    assert raised.value.code == Win32Error.ERROR_TIMEOUT
    assert time.monotonic() - began > 0.04
    handle.close()
    assert threads.join() == [Win32Error.ERROR_OPERATION_ABORTED]


def test_an_abort_lets_writers_go_on(hub: canwire.Hub) -> None:
    handle, threads = candrv.open(hub=hub), Threads()

    def write() -> None:
        for _ in range(150):
            handle.write("1 0 0\n")

    threads.start(write)
    asleep(handle, 1)
    assert handle.abort() >= 99
    assert threads.join() == []
    handle.close()


def test_a_mask_lets_who_waits_look_again(hub: canwire.Hub, peer: Peer) -> None:
    with candrv.open(hub=hub) as handle:
        handle.mask = 0
        threads, got = Threads(), []
        threads.start(lambda: got.append(handle.wait_comm_event()))
        asleep(handle, 1)
        handle.mask = CanbusEvent.RECEIVED
        handle.accept_all()
        peer.send(Frame(1))
        assert threads.join() == []
        assert got == [CanbusEvent.RECEIVED]


def test_the_hub_dies(mortal_hub: Served) -> None:
    address, process = mortal_hub
    with canwire.connect(address) as hub:
        handle, threads = candrv.open(hub=hub), Threads()
        for call in (handle.read_event, handle.wait_comm_event):
            threads.start(call)
        asleep(handle, 2)
        process.terminate()
        assert threads.join() == [Win32Error.ERROR_DEV_NOT_EXIST] * 2
        handle.close()


def test_the_board_is_pulled_out(mortal_hub: Served) -> None:
    with canwire.connect(mortal_hub[0]) as hub:
        handle, threads = candrv.open(hub=hub), Threads()
        for call in (handle.read_event, handle.read_text):
            threads.start(call)
        asleep(handle, 2)
        hub.unplug("HW000104")
        assert threads.join() == [Win32Error.ERROR_DEVICE_REMOVED] * 2
        with pytest.raises(CandrvError) as raised:
            handle.write("1 0 0\n")
        assert raised.value.code == Win32Error.ERROR_DEVICE_REMOVED
        handle.close()


def test_threads_in_virtual_time_have_their_own_timeouts(bench: Bench) -> None:
    """Whoever waits lets time pass, for the others too, and nobody sleeps beyond his own."""
    handle, threads, over = bench.open(), Threads(), []

    def wait(milliseconds: int) -> None:
        with pytest.raises(CandrvError):
            handle.wait_comm_event(milliseconds / 1000)
        over.append((milliseconds, bench.hub.now_ns() // 1_000_000))

    for milliseconds in (300, 100, 200):
        threads.start(wait, milliseconds)
    assert threads.join() == []
    assert {asked for asked, _ in over} == {100, 200, 300}
    assert all(came >= asked for asked, came in over)


def test_a_handle_that_nobody_reads_may_send_for_ever(bench: Bench) -> None:
    handle = bench.open()
    assert bench.peer
    for turn in range(20):
        for n in range(90):
            handle.write(f"{n:x} 0 1 {turn:x}\n")
        bench.run(0.05)
    assert len(handle._channel.receiver.tickets) <= 101
    first = [handle.read_event() for _ in range(200)]
    assert [event.lost for event in first] == [0] * 200
    handle.write("1 0 0\n")
    bench.run(0.01)
    assert handle.read_event().lost == 20 * 90 - 200


def test_outcomes_that_the_channel_had_no_room_for(bench: Bench) -> None:
    """Only with a bus that outruns everybody: nobody waits for them, and what follows is told again."""
    handle = bench.open()
    for n in range(50):
        handle.write(f"{n:x} 0 0\n")
    for _ in range(10):
        bench.peer.send(*(Frame(0x100 + n) for n in range(500)))
        bench.run(0.2)
    while handle.waiting:
        handle.read_event()
    handle.write("7ff 0 0\n")
    bench.run(0.01)
    assert [handle.read_event().event for _ in range(handle.waiting)] == [CanbusEvent.TRANSMITTED]
    assert not handle._channel.receiver.tickets
