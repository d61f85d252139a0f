"""Events to wait for, as VCI's manuals use Windows': auto-reset or manual-reset, assigned to queues and lists."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Protocol

from canwire.errors import BadValue
from canwire.platform import AnyOf, EventDescriptor, wait_readable


class Signal(Protocol):
    """What an event can be assigned to: a queue's end or the device list."""

    @property
    def descriptor(self) -> EventDescriptor:
        """Becomes readable when there is something to look at."""

    def rearm(self) -> None:
        """The signal was taken: give another at the next occasion."""

    @property
    def advance(self) -> Callable[[Callable[[], bool], float | None], bool] | None:
        """On a hub in virtual time: let time pass until the condition holds or the timeout is over."""

    @property
    def clock(self) -> Callable[[], int] | None:
        """On a hub in virtual time: its time in nanoseconds."""

    def stir(self) -> None:
        """The event was set by hand: where programs keep one time, have those who wait for it look again."""


class Event:
    """Signalled or not. `wait` takes an auto-reset event's signal; a manual-reset one stays signalled until `reset`.

    `fileno()` is for select, poll and asyncio's add_reader: readable while the event is signalled. One event may be
    assigned to any number of queues, and `set` signals it by hand.
    """

    def __init__(self, *, manual_reset: bool = False) -> None:
        self.manual_reset = manual_reset
        self._own = EventDescriptor()
        self._signals: list[Signal] = []
        self._lock = threading.RLock()  # over which signals there are, and taking them
        self._any: AnyOf | None = None
        self._closed = False

    def set(self) -> None:
        """Signal the event."""
        self._own.signal()
        for signal in tuple(self._signals):
            signal.stir()

    def reset(self) -> None:
        """Take back every signal there is."""
        self._take()

    def is_set(self) -> bool:
        """Signalled now; takes nothing."""
        with self._lock:
            return wait_readable(self._descriptors(), 0)

    def wait(self, timeout: float | None = None) -> bool:
        """Block until signalled, at most `timeout` seconds (None: no limit); False when the time is over.

        Of several threads that wait for one signal of an auto-reset event one gets it. On a hub in virtual time
        the timeout is virtual, and waiting lets that time pass.
        """
        if timeout is not None and not timeout >= 0:
            raise BadValue(f"timeout {timeout!r}: seconds from 0 up, or None")
        advance = next((signal.advance for signal in self._signals if signal.advance is not None), None)
        if advance is not None:
            signalled = advance(self.is_set, timeout)
            if signalled and not self.manual_reset:
                self._take()
            return signalled
        deadline = None if timeout is None else time.monotonic() + timeout
        left = timeout
        # this also hears of what the event is assigned to while it is waited for
        while wait_readable([self.fileno()], left):
            if self.manual_reset or self._take():
                return True
            left = None if deadline is None else max(0.0, deadline - time.monotonic())
        return False

    def clock_s(self) -> float:
        """Seconds on the clock that `wait` counts by, from some beginning: virtual where it is assigned so."""
        clock = next((signal.clock for signal in self._signals if signal.clock is not None), None)
        return time.monotonic() if clock is None else clock() / 1e9

    def fileno(self) -> int:
        """A descriptor that is readable while the event is signalled, whatever it is assigned to by then."""
        with self._lock:
            if self._any is None:
                self._any = AnyOf([self._own, *(signal.descriptor for signal in self._signals)])
            return self._any.fileno()

    def close(self) -> None:
        """Let go of the descriptors; a second time does nothing."""
        self._closed = True
        self._forget_any()
        self._own.close()

    def __repr__(self) -> str:
        kind = "manual-reset" if self.manual_reset else "auto-reset"
        if self._closed:
            return f"<{kind} event, closed>"
        return f"<{kind} event, {'signalled' if self.is_set() else 'not signalled'}, {len(self._signals)} assigned>"

    def __del__(self) -> None:
        """One that nobody holds any more can signal nobody: its descriptors go with it."""
        if hasattr(self, "_any"):  # made without failure
            self.close()

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The object that this event is assigned to, for code that waits by other means."""
        return tuple(self._signals)

    def bind(self, signal: Signal) -> None:
        """For queues and lists: let this signal the event."""
        with self._lock:
            self._signals.append(signal)
            if self._any is not None:
                self._any.add(signal.descriptor)

    def unbind(self, signal: Signal) -> None:
        """No longer; unknown ones are ignored. To be called before its descriptor is closed."""
        with self._lock:
            if signal in self._signals:
                self._signals.remove(signal)
                if self._any is not None:
                    self._any.remove(signal.descriptor)

    def _take(self) -> bool:
        """Take back every signal there is; was there one?"""
        with self._lock:
            taken = self._own.wait(0)
            for signal in self._signals:
                if signal.descriptor.wait(0):
                    signal.rearm()
                    taken = True
            return taken

    def _descriptors(self) -> list[int]:
        return [self._own.fileno(), *(signal.descriptor.fileno() for signal in self._signals)]

    def _forget_any(self) -> None:
        if self._any is not None:
            self._any.close()
            self._any = None
