"""A sender that waits for room learns that a line sends nothing, but not that the hub had no time for a moment."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from canwire import HubLost
from canwire.socketcan.sockets.line_room import LineRoom
from canwire.socketcan.table import STUCK, UP


class Waiting:
    """One sender waits. The clock moves by `look`, and the hub takes frames as `hub` says."""

    def __init__(self, hub: Callable[[SimpleNamespace], object]) -> None:
        self.interface = SimpleNamespace(flags=UP)
        self.ring = SimpleNamespace(taken=7, free=lambda: 0, arm_free=lambda: None)
        self.looks: list[Callable[[], object]] = []
        descriptor = SimpleNamespace(fileno=lambda: 3, clear=lambda: None)
        loop = SimpleNamespace(
            watch=lambda *told: None, call_in=lambda seconds, call: self.looks.append(call) or call
        )
        setting: Any = SimpleNamespace(loop=loop, interfaces=SimpleNamespace(show=self._show))
        writing: Any = SimpleNamespace(ring=self.ring, descriptor=descriptor, threshold=0)
        interface: Any = self.interface
        LineRoom(setting, interface, writing, lambda: hub(self.ring)).wait(lambda: None)

    def _show(self, interface: SimpleNamespace, flags: int) -> None:
        interface.flags = flags

    def look(self) -> bool:
        """Whether the line counts as stuck after the next look."""
        (call,) = self.looks
        self.looks.clear()
        call()
        return bool(self.interface.flags & STUCK)


def takes(ring: SimpleNamespace) -> None:
    ring.taken += 1


def is_gone(ring: SimpleNamespace) -> None:
    raise HubLost("the hub has ended")


def test_a_hub_that_had_no_time_takes_something_before_it_answers() -> None:
    """A blocking write failed with ENOBUFS on a busy machine."""
    waiting = Waiting(takes)
    assert [waiting.look() for _ in range(4)] == [False] * 4


@pytest.mark.parametrize("hub", [lambda ring: None, is_gone])
def test_a_line_that_sends_nothing_between_two_answers(hub: Callable[[SimpleNamespace], object]) -> None:
    waiting = Waiting(hub)
    assert [waiting.look() for _ in range(2)] == [False, True]
    takes(waiting.ring)
    assert [waiting.look() for _ in range(3)][-1]  # nothing more came: stuck again
    takes(waiting.ring)
    waiting.look()
    assert waiting.looks  # it is looked at for as long as somebody waits
