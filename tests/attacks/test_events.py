"""What a client does to the events it shares with its hub, nobody else feels, the hub least of all."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

import canwire
from canwire.platform import EventDescriptor, close_descriptors
from canwire.platform import linux as platform
from tests.attacks.clients import Honest, hostile
from tests.hubs import LONG_S, Served, serving

SPOIL = """
def spoil(descriptor):  # full, and from now on every write of whoever shares the open file blocks
    os.set_blocking(descriptor, False)
    try:
        while True:
            os.write(descriptor, (2**64 - 2).to_bytes(8, "little"))
    except BlockingIOError:
        os.set_blocking(descriptor, True)

for descriptor in {descriptors}:
    spoil(descriptor)
def work():  # it may well block itself
    channel.reading.ring.arm()
    channel.writing.ring.free_threshold = 64
    for number in range(4):
        channel.send(canwire.Frame(0x1FF, b"worst"))
        channel.writing.ring.arm_free()
threading.Thread(target=work, daemon=True).start()
"""
DRAIN = """
bell = hub.doorbell.fileno()
os.set_blocking(bell, True)
def drain():
    while True:
        os.read(bell, 4096)
threading.Thread(target=drain, daemon=True).start()
for _ in range(20_000):
    hub.doorbell.signal()
"""
HANG_UP = """
os.close(hub.doorbell.fileno())
os.close(channel.reading.descriptor.fileno())
os.close(channel.writing.descriptor.fileno())
"""


@pytest.fixture
def hub(tmp_path: Path) -> Iterator[Served]:
    with contextlib.ExitStack() as stack:
        served = stack.enter_context(serving(tmp_path))
        stack.callback(served.process.kill)
        yield served


@pytest.mark.finding("faults 2")
@pytest.mark.parametrize(
    "script",
    [
        SPOIL.format(descriptors="[channel.reading.descriptor.fileno()]"),
        SPOIL.format(descriptors="[channel.writing.descriptor.fileno()]"),
        SPOIL.format(descriptors="[hub.doorbell.fileno()]"),
        DRAIN,
        HANG_UP,
    ],
    ids=["receive event", "transmit event", "doorbell", "drained doorbell", "all closed"],
)
def test_a_client_cannot_stop_its_hub(hub: Served, script: str) -> None:
    honest = Honest(hub.address)
    honest.exchange(5)
    with hostile(hub.address, script):
        honest.exchange(100)
        with canwire.connect(hub.address) as newcomer:
            assert newcomer.boards()
        hub.process.terminate()
        assert hub.process.wait(LONG_S) == 0
    honest.close()


@pytest.fixture(params=["opened anew", "duplicates"])
def shared(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[EventDescriptor]:
    """A shared event, made as Linux does it and as other systems have to."""
    if request.param == "duplicates":
        monkeypatch.setattr(platform, "_OPENS_ANEW", False)
        monkeypatch.setattr(platform, "_ALL", 1 << 16)
    elif not platform._OPENS_ANEW:
        pytest.skip("descriptors are opened anew on Linux only")
    event = EventDescriptor(shared=True)
    yield event
    event.close()


def test_copies_are_the_same_event(shared: EventDescriptor) -> None:
    own = EventDescriptor.adopt(*shared.copies())
    for one, other in ((shared, own), (own, shared)):
        for _ in range(3):
            one.signal()
        assert [other.wait(0), one.wait(0), other.wait(0)] == [True, False, False]
        one.signal()
        assert one.wait(0)
    own.close()
    shared.signal()
    assert shared.wait(0)


def test_signals_never_block_and_count_as_one(shared: EventDescriptor) -> None:
    own = EventDescriptor.adopt(*shared.copies())
    for _ in range(100_000):
        shared.signal()
    assert [own.wait(0), own.wait(0)] == [True, False]
    own.close()


def test_several_are_adopted_from_one_row(shared: EventDescriptor) -> None:
    events = EventDescriptor.adopt_each(shared.copies() + shared.copies(), 2)
    events[0].signal()
    assert events[1].wait(0)
    for event in events:
        event.close()


@pytest.mark.skipif(not platform._OPENS_ANEW, reason="descriptors are opened anew on Linux only")
@pytest.mark.finding("faults 2")
def test_a_copy_made_blocking_and_full_blocks_nobody_else() -> None:
    event = EventDescriptor(shared=True)
    (copy,) = event.copies()
    with contextlib.suppress(BlockingIOError):
        while True:
            os.write(copy, b"x" * 4096)
    os.set_blocking(copy, True)
    event.signal()
    assert event.wait(0)
    event.clear()  # nothing there, and it does not wait for it
    assert not event.wait(0)
    close_descriptors(copy)
    event.signal()
    event.close()
