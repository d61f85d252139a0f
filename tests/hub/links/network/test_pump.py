"""Who waits for records that are on their way is woken by them; what has arrived is kept no longer."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

from canwire.hub.links.network import wire
from canwire.hub.links.network.incoming import Incoming
from canwire.hub.links.network.notes import OutgoingNotes
from canwire.hub.links.network.pump import Pump
from canwire.hub.links.network.wire import Report
from canwire.ring import RECORD_SIZE, Ring

_ASKED = 2  # by a thread that is about to wait: before it takes the lock, and with it


class Positions(tuple[tuple[int, int], ...]):
    """Positions to wait for that say when a thread is about to wait."""

    def __init__(self, _: object) -> None:
        self.asked = 0
        self.waits = threading.Event()

    def __iter__(self) -> Iterator[tuple[int, int]]:
        self.asked += 1
        if self.asked == _ASKED:
            self.waits.set()
        return super().__iter__()


def test_arriving_records_wake_who_awaits_them() -> None:
    pump = Pump(lambda payload: None)
    pump.add(Incoming(1, Ring(16)))
    positions = Positions([(1, 2)])
    with ThreadPoolExecutor() as others:
        arrived = others.submit(pump.await_arrival, positions, 3600)
        try:
            assert positions.waits.wait(30)
            for first in range(2):
                pump.take(wire.frames(1, first, memoryview(bytes(RECORD_SIZE))))
            assert arrived.result(30)
        finally:
            pump.close()


def test_a_report_confirms_notices() -> None:
    sent: list[bytes] = []
    pump, notes = Pump(sent.append), OutgoingNotes()
    pump.add(notes)
    try:
        notes.add(b"unplugged")
        pump.flush()
        assert (len(sent) > 0, notes.unconfirmed) == (True, True)
        pump.take(wire.reports([Report(notes.number, 1, 1, again=False)]))
        assert not notes.unconfirmed
    finally:
        pump.close()
