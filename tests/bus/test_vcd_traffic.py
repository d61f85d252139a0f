"""Traffic of several nodes as sigrok reads it from the trace: arbitration, both formats, remote frames, any rate."""

from __future__ import annotations

import os
import random
import subprocess
from functools import partial
from pathlib import Path

import pytest

from canwire import Frame, Lab
from tests.bus.test_vcd import blocks_of, told, told_of
from tests.missing import find_program

pytestmark = [pytest.mark.core, pytest.mark.conforms("G-22", "G-04")]

FRAMES = 120


@pytest.mark.parametrize("bit_rate", [125_000, 500_000, 1_000_000])
def test_sigrok_reads_what_the_nodes_received(tmp_path: Path, bit_rate: int) -> None:
    sigrok = find_program("sigrok-cli")
    received = busy(tmp_path / "out.vcd", bit_rate)
    # a sample is a tenth of a bit: the trace counts nanoseconds
    options = f"vcd:downsample={100_000_000 // bit_rate}"
    decoder = f"can:nominal_bitrate={bit_rate}:sample_point=80"
    shown = subprocess.run(
        [sigrok, "-i", str(tmp_path / "out.vcd"), "-I", options, "-P", decoder, "-A", "can=fields:warnings"],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
        env={**os.environ, "HOME": str(tmp_path)},
    )
    assert [told(block) for block in blocks_of(shown.stdout)] == [told_of(frame) for frame in received]
    assert len(received) == FRAMES


def busy(path: Path, bit_rate: int) -> list[Frame]:
    """Five nodes send when they like, often several at once; what a listener received, in the order of the wire."""
    chance = random.Random(bit_rate)
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=bit_rate)
        senders = [bus.node(f"n{k}") for k in range(5)]
        listener = bus.node("listener", listen_only=True)
        bus.trace_levels(path)
        span_ns = FRAMES * 110 * 1_000_000_000 // bit_rate
        for _ in range(FRAMES):
            number = chance.randrange(len(senders))
            at_ns = chance.choice([chance.randrange(span_ns), chance.randrange(20) * span_ns // 20])
            lab.at(at_ns, partial(senders[number].send, some_frame(chance, number)))
        lab.run_until(span_ns)
        lab.run_until_idle()
        lab.run_for(20 / bit_rate)
        assert sum(node.arbitration_losses for node in senders) > FRAMES // 4
        return listener.receive_many(2 * FRAMES)


def some_frame(chance: random.Random, number: int) -> Frame:
    """What sigrok's decoder understands; the identifier ends in the node's number."""
    extended = chance.random() < 0.4
    id = chance.randrange(1 << (26 if extended else 8)) * 8 + number
    if chance.random() < 0.15:
        return Frame(id, extended=extended, remote=True)
    data = chance.choice([chance.randbytes(8), bytes(8), b"\xff" * 8])[: chance.randrange(9)]
    return Frame(id, data, extended=extended)
