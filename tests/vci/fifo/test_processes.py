"""FIFOs between programs: made here, found there by their identifier."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import threading
from typing import Any

import pytest

import canwire
from canwire import vci
from canwire.vci import server
from tests.hubs import Connect

READER, WRITER, FIFO, FIFO2 = vci.IID_IFifoReader, vci.IID_IFifoWriter, vci.IID_IVciFifo, vci.IID_IVciFifo2
ELEMENT = struct.Struct("<QQ")


class AsProgram:
    """Calls of VCI's functions as another process would make them."""

    def __init__(self, hub: canwire.Hub) -> None:
        self._hub = hub

    def __enter__(self) -> None:
        self._before = server._process["hub"]
        server._process["hub"] = self._hub

    def __exit__(self, *_: object) -> None:
        server._process["hub"] = self._before


@pytest.fixture
def elsewhere(hub: canwire.Hub, connect: Connect) -> AsProgram:
    return AsProgram(connect("elsewhere"))


# making and finding


@pytest.mark.conforms("X4-08")
@pytest.mark.parametrize(
    ("capacity", "size", "gets"), [(32, 16, 254), (254, 16, 254), (255, 16, 510), (1, 1, 4072), (3, 5000, 3)]
)
def test_capacity_is_rounded_up_to_whole_pages(hub: canwire.Hub, capacity: int, size: int, gets: int) -> None:
    _, fifo = vci.create_fifo(capacity, size, FIFO)
    with fifo:
        assert (fifo.get_capacity(), fifo.get_entry_size()) == (gets, size)
        assert (fifo.get_free_count(), fifo.get_fill_count(), fifo.get_fill_level()) == (gets, 0, 0)


def test_impossible_fifos(hub: canwire.Hub) -> None:
    for capacity, size in ((0, 16), (65536, 16), (16, 0), (16, 65536), (-1, 1), ("1", 1)):
        with pytest.raises(vci.VciInvalidArgument):
            vci.create_fifo(capacity, size, FIFO)
    for make in (lambda iid: vci.create_fifo(1, 1, iid), lambda iid: vci.access_fifo(vci.VciId(1), iid)):
        with pytest.raises(vci.VciNoInterface, match="ICanSocket"):
            make(vci.IID_ICanSocket)


@pytest.mark.conforms("X4-08")
@pytest.mark.parametrize(
    ("iid", "kind"),
    [(READER, vci.FifoReader), (WRITER, vci.FifoWriter), (FIFO, vci.VciFifo), (FIFO2, vci.VciFifo2)],
)
def test_a_fifo_is_made_with_any_interface(
    hub: canwire.Hub, elsewhere: AsProgram, iid: Any, kind: type
) -> None:
    vciid, made = vci.create_fifo(10, 8, iid)
    with made, elsewhere:
        assert isinstance(made, kind)
        with vci.access_fifo(vciid, FIFO) as found:
            assert found.get_capacity() == made.get_capacity()


@pytest.mark.conforms("X4-08")
def test_a_fifo_lives_as_long_as_somebody_refers_to_it(hub: canwire.Hub, elsewhere: AsProgram) -> None:
    vciid, reader = vci.create_fifo(10, 8, READER)
    with elsewhere:
        writer = vci.access_fifo(vciid, WRITER)
        writer.put_data_entry(b"12345678")
    assert writer.release() == 0
    assert reader.get_data_entry() == b"12345678"
    with elsewhere:
        writer = vci.access_fifo(vciid, WRITER)
    assert reader.release() == 0
    writer.put_data_entry(b"abcdefgh")
    with vci.access_fifo(vciid, READER) as reader:
        assert reader.get_data_entry() == b"abcdefgh"
    assert writer.release() == 0
    with pytest.raises(vci.VciError, match="FIFO") as raised:
        vci.access_fifo(vciid, READER)
    assert raised.value.code == vci.VCI_E_OBJECTID_NOT_FOUND


@pytest.mark.conforms("X4-09")
@pytest.mark.parametrize("iid", [READER, WRITER])
def test_each_end_is_open_once(hub: canwire.Hub, elsewhere: AsProgram, iid: Any) -> None:
    vciid, fifo = vci.create_fifo(10, 8, FIFO)
    with fifo:
        end = vci.access_fifo(vciid, iid)
        with pytest.raises(vci.VciAccessDenied):
            vci.access_fifo(vciid, iid)
        with elsewhere, pytest.raises(vci.VciAccessDenied):
            vci.access_fifo(vciid, iid)
        assert end.release() == 0
        with elsewhere, vci.access_fifo(vciid, iid):
            pass


# what goes through


@pytest.mark.conforms("X4-08", "X4-09")
def test_order_is_kept_and_what_is_too_much_is_refused(hub: canwire.Hub, elsewhere: AsProgram) -> None:
    vciid, reader = vci.create_fifo(32, 16, READER)
    with elsewhere:
        writer = vci.access_fifo(vciid, WRITER)
    with reader, writer:
        for number in range(254):
            writer.put_data_entry(ELEMENT.pack(number, ~number & 0xFF))
        with pytest.raises(vci.VciTxQueueFull):
            writer.put_data_entry(ELEMENT.pack(999, 0))
        found = []
        while reader.get_fill_count():
            block, count = reader.acquire_read()
            found += [ELEMENT.unpack(element)[0] for element in block]
            reader.release_read(count)
        assert found == list(range(254))


@pytest.mark.conforms("X4-12")
def test_levels_and_reset(hub: canwire.Hub, elsewhere: AsProgram) -> None:
    vciid, fifo = vci.create_fifo(32, 16, FIFO2)
    with fifo:
        with elsewhere, vci.access_fifo(vciid, WRITER) as writer:
            for number in range(127):
                writer.put_data_entry(ELEMENT.pack(number, 0))
            assert (fifo.get_fill_level(), fifo.get_fill_count(), fifo.get_free_count()) == (50, 127, 127)
            with pytest.raises(vci.VciAccessDenied):
                fifo.reset()
        with vci.access_fifo(vciid, READER) as reader:
            with pytest.raises(vci.VciAccessDenied):
                fifo.reset()
            assert reader.get_fill_count() == 127
        fifo.reset()
        assert (fifo.get_fill_level(), fifo.get_free_count()) == (0, 254)


@pytest.mark.conforms("X4-12")
def test_the_old_interface_is_part_of_the_new(hub: canwire.Hub) -> None:
    _, fifo = vci.create_fifo(1, 1, FIFO)
    with fifo:
        assert fifo.query_interface(FIFO2).release() == 1
        with fifo.query_interface(READER) as reader:
            assert reader.get_capacity() == fifo.get_capacity()


@pytest.mark.conforms("X4-13")
def test_events_cross_processes(hub: canwire.Hub, elsewhere: AsProgram, event: canwire.Event) -> None:
    vciid, reader = vci.create_fifo(32, 16, READER)
    with elsewhere:
        writer = vci.access_fifo(vciid, WRITER)
    with reader, writer:
        reader.set_threshold(10)
        reader.assign_event(event)
        for number in range(9):
            writer.put_data_entry(ELEMENT.pack(number, 0))
        assert not event.wait(0)
        writer.put_data_entry(ELEMENT.pack(9, 0))
        assert event.wait(30)
        reader.get_data_entry()
        assert not event.wait(0)
        writer.put_data_entry(ELEMENT.pack(10, 0))
        assert event.wait(30)
    assert not event.is_set()


@pytest.mark.conforms("X4-11")
def test_threads_of_a_program_share_an_end(hub: canwire.Hub) -> None:
    vciid, reader = vci.create_fifo(4000, 16, READER)
    writer = vci.access_fifo(vciid, WRITER)

    def write(thread: int) -> None:
        for number in range(500):
            writer.lock()
            block, _ = writer.acquire_write()
            block[0] = ELEMENT.pack(thread, number)
            writer.release_write(1)
            writer.unlock()

    threads = [threading.Thread(target=write, args=(number,)) for number in range(3)]
    with reader, writer:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        found = [ELEMENT.unpack(reader.get_data_entry()) for _ in range(1500)]
    for thread in range(3):
        assert [number for who, number in found if who == thread] == list(range(500))


SUMS = """
import sys, struct
from canwire import vci, Event
vci.initialize(sys.argv[1])
reader = vci.access_fifo(vci.char_to_luid(sys.argv[2]), vci.IID_IFifoReader)
writer = vci.access_fifo(vci.char_to_luid(sys.argv[3]), vci.IID_IFifoWriter)
event, total, left = Event(), 0, int(sys.argv[4])
reader.assign_event(event)
print("ready", flush=True)
while left:
    try:
        block, count = reader.acquire_read()
    except vci.VciRxQueueEmpty:
        assert event.wait(30)
        continue
    for element in block:
        number, twice = struct.unpack("<QQ", element)
        assert twice == 2 * number
        total += number
    left -= count
    reader.release_read(count)
writer.put_data_entry(struct.pack("<Q", total))
"""


@pytest.mark.conforms("X4-08", "X4-09", "X4-10")
def test_two_processes(hub_process: str, source_directory: str, event: canwire.Event) -> None:
    """More elements than fit, each with its double, go to another process; their sum comes back."""
    count = 20_000
    with canwire.connect(hub_process) as hub:
        vci.initialize(hub)
        there, writer = vci.create_fifo(32, 16, WRITER)
        back, reader = vci.create_fifo(1, 8, READER)
        ids = [vci.luid_to_char(vciid) for vciid in (there, back)]
        process = subprocess.Popen(
            [sys.executable, "-c", SUMS, hub_process, *ids, str(count)],
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": source_directory},
        )
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        room = canwire.Event()
        writer.set_threshold(100)
        writer.assign_event(room)
        reader.assign_event(event)
        sent = 0
        while sent < count:
            try:
                block, free = writer.acquire_write()
            except vci.VciTxQueueFull:
                assert room.wait(30)
                continue
            here = min(free, count - sent)
            for k in range(here):
                block[k] = ELEMENT.pack(sent + k, 2 * (sent + k))
            writer.release_write(here)
            sent += here
        assert event.wait(30)
        assert struct.unpack("<Q", reader.get_data_entry())[0] == count * (count - 1) // 2
        assert process.wait(30) == 0
        process.stdout.close()
        room.close()
    server._process.clear()
