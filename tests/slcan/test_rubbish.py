"""Two million random and mutated bytes: nothing escapes, nothing grows, and the dongle answers afterwards."""

from __future__ import annotations

import random
import tracemalloc

import pytest

from canwire.slcan import DIALECTS, Settings
from canwire.slcan.settings import OUTPUT_SIZE
from tests.effort import scaled
from tests.slcan.bench import Bench

COUNT = scaled(2_000_000)  # a quarter of a million commands
TRACED = min(COUNT, 500_000)  # the last ones: what grows does so there, too, and tracing takes its time
BLOCK = 4096
GOOD = b"S4 O C t10021133 T0000010021133 r1002 F M00006000 m00001FF0 V N Z1 L s031C  Y5 D000001001AA b1009".split(
    b" "
)


def block(chosen: random.Random, mutated: bool) -> bytes:
    if not mutated:
        return chosen.randbytes(BLOCK)
    text = bytearray(b"\r".join(chosen.choices(GOOD, k=BLOCK // 8)))
    for _ in range(chosen.randrange(1, 100)):
        text[chosen.randrange(len(text))] = chosen.randrange(256)
    return bytes(text)


@pytest.mark.conforms("CT-01", "CT-23")
@pytest.mark.parametrize("name", DIALECTS)
def test_rubbish_by_the_megabyte(name: str) -> None:
    chosen = random.Random(name)
    bench = Bench(Settings(dialect=DIALECTS[name]))
    dongle = bench.dongle
    done = 0
    while done < COUNT:
        if done >= COUNT - TRACED and not tracemalloc.is_tracing():
            tracemalloc.start()
        data = block(chosen, mutated=done // BLOCK % 2 == 1)
        done += len(data)
        commands, errors = dongle.counters.commands, dongle.counters.errors
        bells = bytes(dongle.output).count(b"\a")
        dongle.feed(data)
        if DIALECTS[name].answers and not dongle.counters.replies_lost:
            assert bytes(dongle.output).count(b"\a") - bells == dongle.counters.errors - errors
        assert dongle.counters.commands >= commands
        assert len(dongle.output) <= OUTPUT_SIZE
        bench.can.sent.clear()
        bench.can.opened.clear()
        bench.can.frames.clear()
        bench.through(dongle.waiting)
        if done // BLOCK % 100:
            bench.read()
    assert tracemalloc.get_traced_memory()[1] < 400_000
    tracemalloc.stop()
    bench.read()
    bench.ask(b"\r")
    assert bench.ask(b"V\r") == dongle.settings.version.encode() + b"\r"
