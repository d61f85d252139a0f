"""Commands to an adapter, one at a time: each waits for its answer. A wrong or missing answer raises. No I/O.

A talk is a generator: it yields an `Ask` and receives the answer, or yields None to rest until `poke` or until
`rest_until_ns`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Generator
from typing import NamedTuple, TypeVar

from canwire.values.frame import Frame
from canwire.values.slcan_text import SlcanReader, parse_slcan_frame

BELL = b"\a"
NEVER = 1 << 62
DONE = re.compile(rb"\Z")  # a bare CR
QUEUED = re.compile(rb"[zZ]?\Z")
_FRAME_LETTERS = b"tTrRdDbB"
_STAMP_DIGITS = 4
_LONGEST = 160


class Ask(NamedTuple):
    """A command without its CR. `answer` matches its answer; BELL is an answer, too, unless the command `searches`.

    A command that searches skips everything up to its answer, such as answers to older commands.
    """

    text: bytes
    answer: re.Pattern[bytes] | None = DONE
    searches: bool = False


class NoAnswer(Exception):
    """No answer arrived in time."""


class WrongAnswer(Exception):
    """The answer does not belong to the command."""


Result = TypeVar("Result")
Talk = Generator[Ask | None, bytes, Result]


class Conversation:
    """Runs a talk over bytes: `write` gets bytes for the adapter, `received` frames with stamps in ms (-1: none).

    Times are in ns, of any monotonic clock. `feed` raises for no bytes from the adapter, however they are split.
    `malformed` counts lines that begin like a frame and are none, `strays` counts answers without a command.
    """

    def __init__(
        self,
        write: Callable[[bytes], object],
        received: Callable[[list[Frame], list[int]], object],
        answer_ns: int,
    ) -> None:
        self.malformed = 0
        self.strays = 0
        self.now_ns = 0
        self.rest_until_ns = NEVER  # when a resting talk is to continue
        self._write = write
        self._received = received
        self._answer_ns = answer_ns
        self._reader = SlcanReader(fd=True)
        self._talk: Talk[None] | None = None
        self._ask: Ask | None = None
        self._deadline_ns = NEVER
        self._inside = False
        self._poked = False

    @property
    def deadline_ns(self) -> int:
        """The time at which `tick` is next needed."""
        return self._deadline_ns if self._ask is not None else self.rest_until_ns

    @property
    def over(self) -> bool:
        return self._talk is None

    def begin(self, talk: Talk[None], now_ns: int) -> None:
        """Run this talk from now on."""
        self.end()
        self.now_ns = now_ns
        self._talk = talk
        self._go_on(lambda: next(talk))

    def end(self) -> None:
        """The adapter is gone: discard the talk and a part of a line."""
        talk, self._talk, self._ask = self._talk, None, None
        self.rest_until_ns = NEVER
        self._reader.clear()
        if talk is not None and not self._inside:
            talk.close()

    def poke(self, now_ns: int) -> None:
        """Continue a resting talk: it may have a command now."""
        if self._inside:
            self._poked = True
        elif self._ask is None:
            self.now_ns = now_ns
            self._resume(b"")

    def tick(self, now_ns: int) -> None:
        """Handle a missing answer, or continue a talk whose rest is over."""
        self.now_ns = max(now_ns, self.now_ns)
        if self._inside or now_ns < self.deadline_ns:
            return
        if self._ask is not None:
            self._fail(NoAnswer(self._ask.text.strip().decode("latin-1")))
        else:
            self._resume(b"")

    def feed(self, data: bytes, now_ns: int) -> None:
        """Bytes from the adapter."""
        self.now_ns = max(now_ns, self.now_ns)
        frames: list[Frame] = []
        stamps: list[int] = []
        for item in self._reader.feed(data.replace(BELL, b"\a\r") if BELL in data else data):
            if isinstance(item, Frame):
                frames.append(item)
                stamps.append(-1)
            elif item and item[0] in _FRAME_LETTERS:
                self._stamped(item, frames, stamps)
            else:
                if frames:  # in the order in which they came
                    self._received(frames, stamps)
                    frames, stamps = [], []
                self._line(item)
        if frames:
            self._received(frames, stamps)

    def _stamped(self, line: bytes, frames: list[Frame], stamps: list[int]) -> None:
        digits = line[-_STAMP_DIGITS:]
        frame = parse_slcan_frame(line[:-_STAMP_DIGITS], fd=True) if digits.isalnum() else None
        try:
            stamp = int(digits, 16)
        except ValueError:
            frame = None
        if frame is None:
            self.malformed += 1
        else:
            frames.append(frame)
            stamps.append(stamp)

    def _line(self, line: bytes) -> None:
        ask = self._ask
        bell = line.endswith(BELL)
        if ask is None or self._inside or ask.answer is None:
            self.strays += 1
        elif ask.searches:
            if not bell and ask.answer.match(line):
                self._resume(line)
        elif bell:
            self._resume(BELL)
        elif len(line) <= _LONGEST and ask.answer.match(line):
            self._resume(line)
        else:
            self._fail(WrongAnswer(f"{line[:20]!r} to {ask.text.decode('latin-1')}"))

    def _resume(self, answer: bytes) -> None:
        talk = self._talk
        if talk is not None:
            self._ask = None
            self._go_on(lambda: talk.send(answer))

    def _fail(self, error: Exception) -> None:
        talk = self._talk
        if talk is not None:
            self._ask = None
            self._go_on(lambda: talk.throw(error))

    def _go_on(self, step: Callable[[], Ask | None]) -> None:
        """Until the talk waits for an answer, or rests with nothing new to say."""
        talk = self._talk
        assert talk is not None
        self._inside = True
        try:
            while True:
                self._poked = False
                ask = step()
                if self._talk is not talk:  # ended from inside
                    talk.close()
                    return
                if ask is not None:
                    self._write(ask.text + b"\r")
                    if ask.answer is not None:
                        self._ask = ask
                        self._deadline_ns = self.now_ns + self._answer_ns
                        return
                elif not self._poked:
                    return
                step = lambda: talk.send(b"")  # noqa: E731
        except StopIteration:
            if self._talk is talk:
                self._talk = None
        finally:
            self._inside = False
