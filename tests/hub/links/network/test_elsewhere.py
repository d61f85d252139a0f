"""A program that only connects over the network: neither the compiled core nor memory that processes share."""

from __future__ import annotations

import sys

import pytest

import canwire
from canwire import Frame
from tests.hub.links.network.places import channel, offered, running
from tests.hubs import LONG_S
from tests.uncompiled import load_uncompiled

pytestmark = [pytest.mark.conforms("PL-11"), pytest.mark.realtime]
SHARED_MEMORY = {"multiprocessing.shared_memory", "_posixshmem"}


def test_a_client_without_the_compiled_core_sends_and_receives() -> None:
    """Frames are packed by one form and unpacked by the other, both ways."""
    with offered() as place, place.here() as here:
        running(here)
        sender = channel(here, 0)
        with load_uncompiled(canwire) as twin:
            before = set(sys.modules)
            with twin.connect(place.address) as hub:
                theirs = hub.open_channel(hub.boards()[1].id, 0)
                theirs.set_up(twin.ChannelMode(receive=64, transmit=64))
                theirs.activate()
                for number in range(20):
                    sender.send(Frame(number, bytes([number]) * 8), timeout=LONG_S)
                found = [theirs.receive(LONG_S) for _ in range(20)]
                assert [(one.id, one.data) for one in found] == [(n, bytes([n]) * 8) for n in range(20)]
                theirs.send(twin.Frame(0x123, b"back"), timeout=LONG_S)
                back = sender.receive(LONG_S)
            loaded = [sys.modules[name] for name in sys.modules if name.startswith("canwire.")]
            assert [one.__name__ for one in loaded if not str(one.__file__).endswith(".py")] == []
            assert not SHARED_MEMORY & (set(sys.modules) - before)
        assert back is not None
        assert (back.id, back.data) == (0x123, b"back")
