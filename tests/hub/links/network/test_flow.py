"""How much is under way in a slow network, and how small it is: a call is never behind more than a moment of data."""

from __future__ import annotations

import random
import zlib
from collections import deque
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadMessage, Frame, frames_to_array
from canwire.hub.links.network import wire
from canwire.hub.links.network.flow.way import FIRST, HOLD_NS, LEAST, Way
from canwire.hub.links.network.incoming import Incoming
from canwire.hub.links.network.mirrors import Outgoing
from canwire.ring import Ring
from canwire.values.packed_records import pack

pytestmark = [pytest.mark.finding("machines 10"), pytest.mark.conforms("PL-11")]
_MS = 1_000_000
STEP_NS = 5 * _MS


def records(count: int, chance: random.Random | None = None) -> bytes:
    """Of frames: cyclic ones with a counter, or none like another."""
    frames = [
        Frame(0x100 + number % 20, bytes([number % 20, 1, 2, 3, 4, 5, 6, number // 20 & 0xFF]))
        if chance is None
        else Frame(chance.getrandbits(11), chance.randbytes(8))
        for number in range(count)
    ]
    array = frames_to_array(frames)
    array["time_ns"] = [10**18 + 230_000 * number for number in range(count)]
    return array.tobytes()


class Played(NamedTuple):
    """Records that came, and how long each payload was in the network, in ms."""

    came: int
    took_ms: list[float]


def play(way: Way, bytes_s: float, way_ms: int, seconds: int, frames_s: int) -> Played:
    """A ring that is filled so quickly, over a network of that speed that keeps whatever it is given."""
    original, copy = Ring(8192, exact=True), Ring(8192, exact=True)
    outgoing, incoming = Outgoing(1, original, frames=True), Incoming(1, copy)
    outgoing.belongs_to(way)
    block = records(64, random.Random(1))
    there: deque[tuple[int, bytes]] = deque()
    back: deque[tuple[int, wire.Report]] = deque()
    took_ms: list[float] = []
    free_ns = written = 0
    for now_ns in range(0, seconds * 1000 * _MS, STEP_NS):
        while written < now_ns * frames_s // 10**9:
            original.put_bytes(block[written % 64 * 80 :][:80])
            written += 1
        for payload in outgoing.batches(now_ns):
            free_ns = max(free_ns, now_ns) + round((len(payload) + 40) / bytes_s * 1e9)
            took_ms.append((free_ns - now_ns) / _MS)
            there.append((free_ns + way_ms * _MS, payload))
        while there and there[0][0] <= now_ns:
            _, first, found, _ = wire.frames_in(there.popleft()[1])
            incoming.accept(first, found)
            copy.release(copy.fill())
            incoming.sent(outgoing.sent if way.asks else 0)
            report = incoming.report(now_ns, at_once=True)
            assert report is not None
            assert not report.again or way.asks
            back.append((now_ns + way_ms * _MS, report._replace(again=False)))
        while back and back[0][0] <= now_ns:
            outgoing.acknowledge(back.popleft()[1], now_ns)
    return Played(incoming.received, took_ms)


@pytest.mark.parametrize("way_ms", [1, 100])
def test_data_never_wait_long_in_a_slow_network_and_fill_it(way_ms: int) -> None:
    way = Way()
    came, took_ms = play(way, 50_000, way_ms, seconds=12, frames_s=4_500)
    assert way.slow
    assert max(took_ms) < 1000
    assert sum(took_ms) / len(took_ms) < 300
    assert came > 0.75 * 12 * 50_000 / 15  # bytes of a frame that nothing can squeeze


def test_a_quick_network_gets_all_it_takes() -> None:
    way = Way()
    play(way, 100e6, 20, seconds=1, frames_s=100_000)
    assert not way.slow
    assert way._limit > 16 * FIRST


def test_the_other_machine_may_take_its_time() -> None:
    way = Way()
    way.came(0, 10 * _MS)
    way.came(0, 3_000 * _MS)
    assert not way.slow
    assert way.room() == FIRST


def test_a_window_has_a_least_size() -> None:
    way = Way()
    way.sent(FIRST)
    way.came(0, _MS)
    assert not way.room()
    assert way.waits()
    assert not way.waits()
    way.came(_MS, 10_000 * _MS)
    way.gone(FIRST, 1)
    assert way.room() == LEAST


def test_the_more_there_are_the_longer_small_batches_wait() -> None:
    way = Way()
    way.shared_with(4)
    assert way.hold_ns == HOLD_NS
    way.shared_with(50)
    assert 20 * HOLD_NS < way.hold_ns < 40 * HOLD_NS


@pytest.mark.parametrize("squeeze", [False, True])
def test_frames_of_a_full_batch_are_small(squeeze: bool) -> None:
    raw = records(64)
    payload = wire.packed_frames(7, 1 << 40, memoryview(raw), 5, squeeze=squeeze)
    ring, first, found, stamp = wire.frames_in(payload)
    assert (ring, first, bytes(found), stamp) == (7, 1 << 40, raw, 5)
    assert len(payload) / 64 < (6 if squeeze else 15)


def test_what_cannot_be_squeezed_is_not() -> None:
    raw = memoryview(random.Random(2).randbytes(160))
    assert wire.packed_frames(1, 0, raw, squeeze=True) == wire.packed_frames(1, 0, raw)


@given(st.binary(max_size=200), st.booleans())
def test_squeezed_rubbish_is_refused(rubbish: bytes, once: bool) -> None:
    head = wire.packed_frames(1, 0, memoryview(records(64)), squeeze=True)[:16]
    work = zlib.compressobj(1, zlib.DEFLATED, -12)
    body = work.compress(rubbish) + work.flush() if once else rubbish
    try:
        wire.frames_in(head + body)
    except BadMessage:
        return


def test_a_few_bytes_that_are_megabytes_are_refused() -> None:
    head = wire.packed_frames(1, 0, memoryview(records(64)), squeeze=True)[:16]
    work = zlib.compressobj(9, zlib.DEFLATED, -15)
    bomb = work.compress(bytes(1_000_000)) + work.flush()
    with pytest.raises(BadMessage, match="more than 131072 bytes"):
        wire.frames_in(head + bomb)
    whole = pack(bytearray(records(3)))
    work = zlib.compressobj(9, zlib.DEFLATED, -15)
    with pytest.raises(BadMessage, match="not whole"):
        wire.frames_in(head + (work.compress(whole) + work.flush())[:-2])
