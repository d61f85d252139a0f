"""A signal in the middle of waiting leaves nobody else waiting for ever."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import pytest

from canwire import Event
from canwire.candrv.handle.waiting import WaitingRoom

LONG = 30  # seconds after which something that should happen never will
ready: list[bool] = []


class RealTime:
    """As much of a hub as a waiting room asks for."""

    virtual = timed = False


class Interrupted:
    """A lock during whose `when` a signal comes: its handler raises as soon as that call is over."""

    def __init__(self, lock: Any, when: str) -> None:
        self._lock, self._when = lock, when

    def _then(self, name: str, result: Any) -> Any:
        if name == self._when:
            self._when = ""
            raise KeyboardInterrupt
        return result

    def acquire(self, *arguments: Any) -> Any:
        return self._then("acquire", self._lock.acquire(*arguments))

    def release(self) -> None:
        self._then("release", self._lock.release())


def waits(room: Any) -> bool:
    """As another thread of the program does."""
    with room.lock:
        return bool(room.until(lambda: bool(ready), None, lambda: None))


@pytest.fixture(autouse=True)
def nothing_ready() -> None:
    ready.clear()


def interrupt_in_event(room: Any) -> None:
    def wait(left: float | None) -> bool:
        raise KeyboardInterrupt

    room.event = type("Deaf", (), {"wait": staticmethod(wait)})()


def interrupt_behind(when: str) -> Callable[[Any], None]:
    def prepare(room: Any) -> None:
        room.lock = Interrupted(room.lock, when)
        room.event.set()

    return prepare


@pytest.mark.conforms("FS-21")
@pytest.mark.parametrize(
    "prepare", [interrupt_in_event, interrupt_behind("release"), interrupt_behind("acquire")]
)
def test_an_interrupt_at_every_step(prepare: Callable[[Any], None]) -> None:
    room: Any = WaitingRoom(RealTime())  # type: ignore[arg-type]
    lock = room.lock
    lock.acquire()
    prepare(room)
    with pytest.raises(KeyboardInterrupt):
        room.until(lambda: False, None, lambda: None)
    assert lock.locked()
    room.lock, room.event = lock, Event()
    looked: list[bool] = []
    other = threading.Thread(target=lambda: looked.append(waits(room)))
    lock.release()
    other.start()
    with lock:
        ready.append(True)
        room.wake()
    other.join(LONG)
    assert looked == [True]
