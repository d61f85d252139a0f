"""AutoResetEvent and ManualResetEvent: canwire's events with the names of .NET.

Each call of V3 that needs an event also accepts a plain `canwire.Event`.
Source: VCI V3 .NET manual 2.2 and 3.1.
"""

from __future__ import annotations

from collections.abc import Sequence

from canwire import Event

FOREVER = -1


class WaitHandle(Event):
    """The common part of both kinds."""

    def __init__(self, initial_state: bool = False, *, manual_reset: bool = False) -> None:
        super().__init__(manual_reset=manual_reset)
        if initial_state:
            self.set()

    def wait_one(self, timeout_ms: int = FOREVER, exit_context: bool = False) -> bool:
        """WaitOne: wait for the signal, `timeout_ms` milliseconds at most; returns whether it came.

        `exit_context` is ignored; in .NET it matters only in synchronization domains.
        """
        return self.wait(_seconds(timeout_ms))

    @staticmethod
    def wait_all(events: Sequence[Event], timeout_ms: int = FOREVER, exit_context: bool = False) -> bool:
        """WaitAll: wait for the signals of all events, `timeout_ms` milliseconds at most in total.

        If one does not come, the events whose signals were consumed are signalled again. `exit_context` is ignored.
        """
        taken: list[Event] = []
        starts_s = [event.clock_s() for event in events]
        for event, start_s in zip(events, starts_s, strict=True):
            left_s = None if timeout_ms < 0 else max(0.0, timeout_ms / 1000 - (event.clock_s() - start_s))
            if not event.wait(left_s):
                for one in taken:
                    one.set()
                return False
            taken.append(event)
        return True


class AutoResetEvent(WaitHandle):
    """An event whose signal is reset by the one wait that it ends."""

    def __init__(self, initial_state: bool = False) -> None:
        super().__init__(initial_state)


class ManualResetEvent(WaitHandle):
    """An event that stays signalled until `reset`."""

    def __init__(self, initial_state: bool = False) -> None:
        super().__init__(initial_state, manual_reset=True)


def _seconds(timeout_ms: int) -> float | None:
    return None if timeout_ms < 0 else timeout_ms / 1000
