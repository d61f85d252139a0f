"""The server's timers: those that were cancelled do not stay for their time."""

from __future__ import annotations

import gc
import sys

import pytest

if sys.platform != "linux":
    pytest.skip("SocketCAN programs are Linux's", allow_module_level=True)

from canwire.socketcan.loop import Loop, Timer


@pytest.fixture(autouse=True)
def nothing_else_to_collect() -> None:
    """What is there already is left alone: there are a million objects of other tests."""
    gc.freeze()


def there() -> int:
    gc.collect()
    return sum(type(found) is Timer for found in gc.get_objects())


def test_cancelled_timers_do_not_stay_for_their_time() -> None:
    """A program that sets up a cyclic message with a far next turn again and again."""
    loop = Loop()
    before = there()
    live = [loop.call_in(3600, lambda: None) for _ in range(100)]
    for _ in range(10_000):
        loop.call_in(7200, lambda: None).cancel()
    assert there() - before <= 2 * len(live) + 1
    loop.close()


def test_what_is_left_is_called_in_order() -> None:
    loop = Loop()
    called: list[int] = []
    for number in range(300):
        loop.call_in(-(number % 7), lambda number=number: called.append(number))  # type: ignore[misc]
        loop.call_in(3600, lambda: None).cancel()
    loop.call_in(0, loop.stop)
    loop.run()
    assert sorted(called) == list(range(300))
    assert [-(number % 7) for number in called] == sorted(-(number % 7) for number in called)
    loop.close()
