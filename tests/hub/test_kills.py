"""Clients that die without a word, and clients that lie: real processes, real signals."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import canwire
from canwire.errors import InUse
from canwire.hub.protocol.queues import transmit_offset
from tests import warm
from tests.hubs import serving

TIMING = canwire.BitTiming.for_bit_rate(1_000_000, clock_hz=80_000_000)
PATIENCE_S = 60.0

# writes batches for ever: each frame holds the same number eight times, so that a torn one shows
WRITER = """
import sys, numpy, canwire
hub = canwire.connect(sys.argv[1])
board = hub.boards()[0].id
control = hub.open_control(board, 0)
control.initialise(canwire.LineMode(canwire.BitTiming.for_bit_rate(1_000_000, clock_hz=80_000_000)))
control.start()
scheduler = hub.open_scheduler(board, 0)
channel = hub.open_channel(board, 0)
channel.set_up(canwire.ChannelMode(1, 4096, frames=False))
channel.activate()
batch = canwire.frames_to_array([canwire.Frame(n, bytes([n]) * 8) for n in range(256)])
print("writing", flush=True)
while True:
    channel.send_array(batch)
    channel.writing.threshold = 1024
    channel.writing.wait(10)
"""


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    """Of a hub in a process of its own."""
    with serving(tmp_path) as (path, _):
        yield path


@contextlib.contextmanager
def writer(address: str) -> Iterator[subprocess.Popen[bytes]]:
    with warm.Popen([sys.executable, "-c", WRITER, address], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"writing\n"
        try:
            yield process
        finally:
            process.kill()


def listener(hub: canwire.Hub, line: int, queue: int = 65_536) -> canwire.HubChannel:
    board = hub.boards()[0].id
    control = hub.open_control(board, line)
    control.initialise(canwire.LineMode(TIMING))
    control.start()
    channel = hub.open_channel(board, line)
    channel.set_up(canwire.ChannelMode(queue, 0))
    channel.activate()
    return channel


def freed(hub: canwire.Hub, line: int) -> bool:
    """Nobody holds anything on this line, which the hub notices by itself."""
    event = canwire.Event()
    for _ in range(600):  # half a minute
        status = hub.line_status(hub.boards()[0].id, line)
        if not (status.control_holder or status.scheduler_holder or status.channels):
            return True
        event.wait(0.05)
    return False


@pytest.mark.conforms("G-19", "PL-13")
def test_a_killed_writer_leaves_whole_frames_and_nothing_held(address: str) -> None:
    with canwire.connect(address) as hub:
        channel = listener(hub, 1)
        board = hub.boards()[0].id
        for _ in range(5):
            with writer(address) as process:
                seen = 0
                with pytest.raises(InUse, match=str(process.pid)):
                    hub.open_control(board, 0)
                while seen < 3000:
                    frames = channel.receive_many(4096, PATIENCE_S)
                    assert frames, "the writer's frames arrive"
                    seen += len(frames)
                    assert all(frame.data == bytes([frame.id]) * 8 for frame in frames)
                os.kill(process.pid, signal.SIGKILL)
                process.wait()
                assert freed(hub, 0)
                assert all(
                    frame.data == bytes([frame.id]) * 8 for frame in channel.receive_many(1 << 17, timeout=0)
                )
        assert channel.status().lost == 0
        hub.open_control(board, 0).close()


@pytest.mark.smoke
def test_others_notice_nothing_of_a_client_that_dies(address: str) -> None:
    """Two of them talk while a third one is killed in the middle of everything, again and again."""
    with canwire.connect(address) as one, canwire.connect(address) as other:
        receiving, replies = listener(one, 1), other.open_channel(one.boards()[1].id, 0)
        board = one.boards()[1].id
        control = other.open_control(board, 0)
        control.initialise(canwire.LineMode(TIMING))
        control.start()
        replies.set_up(canwire.ChannelMode(16, 64, frames=False))
        replies.activate()
        for round in range(3):
            with writer(address) as process:
                replies.send(canwire.Frame(0x700, bytes([round])))
                os.kill(process.pid, signal.SIGKILL)
            replies.send(canwire.Frame(0x701, bytes([round])))
        wanted = [(identifier, bytes([round])) for round in range(3) for identifier in (0x700, 0x701)]
        got: list[tuple[int, bytes]] = []
        while len(got) < len(wanted):
            frames = receiving.receive_many(4096, PATIENCE_S)
            assert frames
            got += [(frame.id, frame.data) for frame in frames if frame.id >= 0x700]
        assert got == wanted


@pytest.mark.parametrize("words", [{8: 1 << 40}, {8: -1 & (1 << 64) - 1}, {16: 12345}, {17: 1 << 63, 8: 7}])
def test_a_client_that_writes_nonsense_into_its_rings_harms_itself_only(
    address: str, words: dict[int, int]
) -> None:
    """Head, tail and wanted words of the transmit ring, as ring.py draws them."""
    with canwire.connect(address) as liar, canwire.connect(address) as honest:
        receiving = listener(honest, 1)
        sending = listener(liar, 0)
        bad = liar.open_channel(liar.boards()[0].id, 0)
        bad.set_up(canwire.ChannelMode(16, 64, frames=False))
        bad.activate()
        ring_words = bad.writing.ring.acquire_free(1).obj  # the mapping itself
        begin = transmit_offset(bad.reading.ring.capacity)
        shared = memoryview(ring_words).cast("B")[begin : begin + 256].cast("Q")
        for at, value in words.items():
            shared[at] = value
        liar.doorbell.signal()
        good = liar.open_channel(liar.boards()[0].id, 0)
        good.set_up(canwire.ChannelMode(16, 64, frames=False))
        good.activate()
        good.send(canwire.Frame(0x123, b"still here"[:8]))
        frame = receiving.receive(PATIENCE_S)
        assert frame is not None
        while frame.id != 0x123:
            frame = receiving.receive(PATIENCE_S)
            assert frame is not None
        assert honest.boards()
        assert sending.status().lost == 0
        shared.release()


def test_garbage_in_the_transmit_memory_never_reaches_the_bus(address: str) -> None:
    with canwire.connect(address) as hub:
        receiving = listener(hub, 1)
        board = hub.boards()[0].id
        listener(hub, 0)
        channel = hub.open_channel(board, 0)
        channel.set_up(canwire.ChannelMode(1, 256, frames=False))
        channel.activate()
        ring = channel.writing.ring
        for seed in range(64):
            room = ring.acquire_free(1)
            room[:] = (bytes([seed, 0xFF, 0xA5, 0x80 + seed]) * 20)[:80]
            ring.commit(1)
        channel.send(canwire.Frame(0x7FF, b"end"))
        while (frame := receiving.receive(PATIENCE_S)) is not None and frame.data != b"end":
            assert frame.id <= (0x1FFF_FFFF if frame.extended else 0x7FF)
            assert not frame.fd
        assert frame is not None
        status = channel.status()
        assert status.sent == status.delivered + status.aborted + status.refused + status.pending
        assert status.refused > 0
        assert hub.line_status(board, 0).refused == status.refused
