"""How a thread waits for its turn without a message: six words in memory that it shares with its hub.

    word  writer   what
    0     program  asked: how often it has begun to wait
    1     program  until when it waits, ns
    2     program  stirs: how often its other threads were asked to check again
    3     hub      given: the `asked` that was answered by a turn
    4     hub      the time then, ns
    5     program  calls: how often this very thread was asked to check again, by another one

After each write the program signals its doorbell, the hub an event. The hub trusts nothing here: the worst that a
program can write affects only how long it waits itself.
"""

from __future__ import annotations

from canwire import _mem

SIZE = 4096
_ASKED = 0
_UNTIL = 1
_STIRS = 2
_GIVEN = 3
_NOW = 4
_CALLS = 5
_M63 = (1 << 63) - 1


class TurnPage:
    """Either end of it; `memory` has SIZE bytes."""

    def __init__(self, memory: memoryview) -> None:
        self._memory = memory
        self._words = _mem.words_of(memory)
        self.seen = 0  # the last `asked` that the hub has looked at
        self._stirs_seen = 0
        self._calls_seen = 0

    # the program's

    def ask(self, until_ns: int) -> int:
        """Begin to wait; the number of this wait."""
        asked = _mem.load_acquire(self._words, _ASKED) + 1
        _mem.store_release(self._words, _UNTIL, until_ns)
        _mem.store_release(self._words, _ASKED, asked)
        return asked

    def given(self, asked: int) -> bool:
        """Whether this wait is over."""
        return _mem.load_acquire(self._words, _GIVEN) == asked

    def now_ns(self) -> int:
        """When it was over."""
        return _mem.load_acquire(self._words, _NOW)

    def stir(self) -> None:
        _mem.store_release(self._words, _STIRS, _mem.load_acquire(self._words, _STIRS) + 1)

    def call(self) -> None:
        """Call the owner of this page from a thread that takes no turns: it checks again, perhaps after its next
        wait.
        """
        _mem.store_release(self._words, _CALLS, _mem.load_acquire(self._words, _CALLS) + 1)
        self.stir()

    # the hub's

    def asked(self) -> bool:
        """Whether the program has begun a wait since the last `asked`."""
        asked = _mem.load_acquire(self._words, _ASKED)
        new = asked != self.seen
        self.seen = asked
        return new

    def until_ns(self) -> int:
        return _mem.load_acquire(self._words, _UNTIL) & _M63

    def stirred(self) -> bool:
        """Whether the program has called `stir` since the last `stirred`."""
        stirs = _mem.load_acquire(self._words, _STIRS)
        new = stirs != self._stirs_seen
        self._stirs_seen = stirs
        return new

    def called(self) -> bool:
        """Whether the program has called `call` since the last `called`."""
        calls = _mem.load_acquire(self._words, _CALLS)
        new = calls != self._calls_seen
        self._calls_seen = calls
        return new

    def give(self, now_ns: int) -> None:
        """End the wait that the last `asked` has seen."""
        _mem.store_release(self._words, _NOW, now_ns)
        _mem.store_release(self._words, _GIVEN, self.seen)
