"""A transmit ring full of rubbish, and a doorbell that never rests: its writer waits, nobody else does."""

from __future__ import annotations

import pytest

from canwire import ChannelMode, Frame
from canwire.hub.handles.channel import HubChannel
from tests.hub.in_memory import Bench, bench_of

RUBBISH = 20_000
AT_ONCE = 4096  # records refused in a millisecond


bench = bench_of()


def spoil(channel: HubChannel, count: int) -> None:
    for _ in range(count):
        channel.writing.ring.put_bytes(b"\xff" * 80)


@pytest.mark.finding("faults 5")
@pytest.mark.parametrize("prioritised", [False, True])
def test_ringing_again_and_again_gains_nothing(bench: Bench, prioritised: bool) -> None:
    liar, honest = bench.hub("liar"), bench.hub("honest")
    bench.control(honest)
    bench.control(honest, 1)
    bad = bench.channel(liar, 0, ChannelMode(1, 32_768, frames=False, prioritised=prioritised))
    good, heard = bench.channel(honest), bench.channel(honest, 1)
    spoil(bad, RUBBISH)
    session = bench.link(liar).session
    for _ in range(1000):
        bench.world.kick(session)
    assert bad.status().refused == AT_ONCE
    good.send(Frame(0x123))
    bench.world.kick(bench.link(honest).session)
    bench.world.kick(session)
    assert bad.status().refused == AT_ONCE
    honest.run_for(0.0005)
    frame = heard.receive()
    assert frame is not None
    assert frame.id == 0x123
    honest.run_for(0.0006)
    assert bad.status().refused in (AT_ONCE, 2 * AT_ONCE)
    honest.run_for(0.01)
    assert bad.status().refused == RUBBISH
    bad.send(Frame(0x124))
    bench.world.kick(session)
    honest.run_for(0.001)
    frame = heard.receive()
    assert frame is not None
    assert frame.id == 0x124


@pytest.mark.finding("faults 5")
def test_several_writers_of_rubbish_share_what_one_may(bench: Bench) -> None:
    liars = [bench.hub(f"liar {number}") for number in range(4)]
    bench.control(liars[0])
    channels = [bench.channel(liar, 0, ChannelMode(1, 16_384, frames=False)) for liar in liars]
    for channel in channels:
        spoil(channel, 10_000)
    for _ in range(100):
        bench.world.kick_all()
    assert sum(channel.status().refused for channel in channels) <= AT_ONCE + len(liars)
