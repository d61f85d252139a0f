"""Events to wait for, like those of Windows in VCI's manuals: auto-reset or manual-reset, assigned to queues."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Protocol

from canwire.errors import BadValue
from canwire.platform import AnyOf, EventDescriptor, wait_readable


class Signal(Protocol):
    """An object that an event can be assigned to: the end of a queue, or the device list."""

    @property
    def descriptor(self) -> EventDescriptor:
        """Becomes readable when the object's condition may be met."""

    def rearm(self) -> None:
        """The signal was consumed: give another one at the next change."""

    @property
    def advance(self) -> Callable[[Callable[[], bool], float | None], bool] | None:
        """On a hub in virtual time: let time pass until the condition is true, or until the timeout."""

    @property
    def clock(self) -> Callable[[], int] | None:
        """On a hub in virtual time: its time in nanoseconds."""

    def stir(self) -> None:
        """The event was set by `set`: in lockstep, make the threads that wait for it check again."""


class Event:
    """An event, signalled or not. `wait` resets an auto-reset event; a manual-reset one stays signalled until `reset`.

    `fileno()` is for select, poll and asyncio's add_reader: readable while the event is signalled. One event may be
    assigned to any number of queues; `set` signals it, too.
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
        """Clear all signals."""
        self._take()

    def is_set(self) -> bool:
        """True if the event is signalled; does not reset it."""
        with self._lock:
            return wait_readable(self._descriptors(), 0)

    def wait(self, timeout: float | None = None) -> bool:
        """Block until signalled, at most `timeout` seconds (None: no limit); False after the timeout.

        If several threads wait for one signal of an auto-reset event, one of them gets it. On a hub in virtual time
        the timeout is in virtual time, and waiting lets that time pass.
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
        """Seconds on the clock that `wait` uses, from any start: virtual if the assigned objects' time is."""
        clock = next((signal.clock for signal in self._signals if signal.clock is not None), None)
        return time.monotonic() if clock is None else clock() / 1e9

    def fileno(self) -> int:
        """A descriptor that is readable while the event is signalled, also after later assignments."""
        with self._lock:
            if self._any is None:
                self._any = AnyOf([self._own, *(signal.descriptor for signal in self._signals)])
            return self._any.fileno()

    def close(self) -> None:
        """Close the descriptors; a second call has no effect."""
        self._closed = True
        self._forget_any()
        self._own.close()

    def __repr__(self) -> str:
        kind = "manual-reset" if self.manual_reset else "auto-reset"
        if self._closed:
            return f"<{kind} event, closed>"
        return f"<{kind} event, {'signalled' if self.is_set() else 'not signalled'}, {len(self._signals)} assigned>"

    def __del__(self) -> None:
        """Close the descriptors of an event without references."""
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
        """Undo `bind`; an unknown signal is ignored. Call this before its descriptor is closed."""
        with self._lock:
            if signal in self._signals:
                self._signals.remove(signal)
                if self._any is not None:
                    self._any.remove(signal.descriptor)

    def _take(self) -> bool:
        """Clear all signals; True if there was one."""
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
