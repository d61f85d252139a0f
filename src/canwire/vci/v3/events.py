"""AutoResetEvent and ManualResetEvent: canwire's events under the names of .NET.

Wherever V3 takes an event, it takes a plain `canwire.Event` as well.
Source: VCI V3 .NET manual 2.2 and 3.1.
"""

from __future__ import annotations

from collections.abc import Sequence

from canwire import Event

FOREVER = -1


class WaitHandle(Event):
    """What both kinds share."""

    def __init__(self, initial_state: bool = False, *, manual_reset: bool = False) -> None:
        super().__init__(manual_reset=manual_reset)
        if initial_state:
            self.set()

    def wait_one(self, timeout_ms: int = FOREVER, exit_context: bool = False) -> bool:
        """WaitOne: wait for the signal, at most so many milliseconds; False when none came.

        `exit_context` means nothing here, nor outside of .NET's own synchronization domains.
        """
        return self.wait(_seconds(timeout_ms))

    @staticmethod
    def wait_all(events: Sequence[Event], timeout_ms: int = FOREVER, exit_context: bool = False) -> bool:
        """WaitAll: wait for the signals of all of them, at most so many milliseconds altogether.

        When one does not come, signals taken of others before are given back. `exit_context` means nothing here.
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
    """Whoever waits takes the signal."""

    def __init__(self, initial_state: bool = False) -> None:
        super().__init__(initial_state)


class ManualResetEvent(WaitHandle):
    """Stays signalled until `reset`."""

    def __init__(self, initial_state: bool = False) -> None:
        super().__init__(initial_state, manual_reset=True)


def _seconds(timeout_ms: int) -> float | None:
    return None if timeout_ms < 0 else timeout_ms / 1000
