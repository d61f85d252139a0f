"""What benchmarks/native.py measures in Python: the first word says which."""

from __future__ import annotations

import os
import sys
import time

from canwire import Event, vci
from canwire.vci import IID_IFifoReader, IID_IFifoWriter

ROOM, SIZE = 4000, 80
FRAMES, SINGLE, ROUNDS = 3_000_000, 300_000, 5000


def write_frames(writer: vci.FifoWriter[bytes], count: int, *, batches: bool) -> None:
    event = Event()
    writer.assign_event(event)
    put, cell = 0, bytes(SIZE)
    while put < count:
        try:
            if batches:
                block, room = writer.acquire_write()
                room = min(room, 256, count - put)
                block.memory[: room * SIZE] = bytes(room * SIZE)
                writer.release_write(room)
                put += room
            else:
                writer.put_data_entry(cell)
                put += 1
        except vci.VciTxQueueFull:
            event.wait(0.01)
    while writer.get_free_count() < ROOM:
        time.sleep(0.001)


def frames(count: int, *, batches: bool) -> None:
    vci.initialize()
    id_, fifo = vci.create_fifo(ROOM, SIZE)
    child = os.fork()
    if child == 0:
        vci.initialize()
        write_frames(vci.access_fifo(id_, IID_IFifoWriter), count, batches=batches)
        os._exit(0)
    reader, event = vci.access_fifo(id_, IID_IFifoReader), Event()
    reader.assign_event(event)
    got, begun = 0, 0.0
    while got < count:
        try:
            if batches:
                _, there = reader.acquire_read()
                reader.release_read(there)
                got += there
            else:
                reader.get_data_entry()
                got += 1
        except vci.VciRxQueueEmpty:
            event.wait(0.01)
            continue
        begun = begun or time.monotonic()
    what = "batches" if batches else "single"
    print(f"Python {what:8} {count / (time.monotonic() - begun) / 1e6:6.2f} M frames/s", flush=True)
    os.waitpid(child, 0)
    fifo.release()


def one_way() -> None:
    vci.initialize()
    (there, first), (back, second) = vci.create_fifo(100, SIZE), vci.create_fifo(100, SIZE)
    child = os.fork()
    vci.initialize()
    reader = vci.access_fifo(back if child else there, IID_IFifoReader)
    writer = vci.access_fifo(there if child else back, IID_IFifoWriter)
    event, spans = Event(), []
    reader.assign_event(event)
    for _ in range(ROUNDS):
        begun = time.monotonic()
        if child:
            writer.put_data_entry(bytes(SIZE))
        while not reader.get_fill_count():
            event.wait(1)
        reader.get_data_entry()
        if not child:
            writer.put_data_entry(bytes(SIZE))
        spans.append((time.monotonic() - begun) / 2)
    if not child:
        os._exit(0)
    spans.sort()
    print(f"Python one way  {spans[ROUNDS // 2] * 1e6:6.1f} us (median)", flush=True)
    os.waitpid(child, 0)
    first.release()
    second.release()


if __name__ == "__main__":
    if sys.argv[1] == "one-way":
        one_way()
    else:
        frames(FRAMES if sys.argv[1] == "batches" else SINGLE, batches=sys.argv[1] == "batches")
