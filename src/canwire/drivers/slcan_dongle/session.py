"""The commands to an adapter from plugging in to the end, as a talk: section 1.4 of the CANBUS manual. No I/O.

greet     CR CR CR V, whose answer shows the dialect; N; C (an earlier program may have left the channel open); Z1
open      S or s, M and m if needed, O or L, F to discard older flags
on        frames one after the other; F every 750 ms and after an error
recover   CR CR CR V until it is answered again
"""

from __future__ import annotations

import re
from collections.abc import Callable

from canwire.drivers.outside import Trouble
from canwire.drivers.slcan_dongle.conversation import BELL, NEVER, QUEUED, Ask, NoAnswer, Talk, WrongAnswer
from canwire.drivers.slcan_dongle.dialects import Dialect, recognised
from canwire.drivers.slcan_dongle.user import Adapter, Setup, User

POLL_NS = 750_000_000  # F: every 500 to 1000 ms (source: CANBUS manual, 1.4)
TRANSMIT_FULL = 1 << 1
_VERSION = re.compile(rb"[^zZ\a].*")
_NUMBER = re.compile(rb"N[\x21-\x7e]*\Z")
_FLAGS = re.compile(rb"F[0-9A-Fa-f]{2}\Z")
_ATTEMPTS = 3  # to find an adapter again, or to get a frame into it
_IN_A_ROW = 64  # frames without answers
_FULL_NS = 1_000_000  # after "queue full", a frame tries again; twice as long each time
_LONGEST_FULL_NS = 64_000_000


class _Refused(Exception):
    """The adapter answered BELL, and no retry helps."""


class Session:
    """One adapter on one port. `rates` replaces digits of S, such as 7, for adapters that differ (ruling 29)."""

    def __init__(
        self,
        user: User,
        now: Callable[[], int],
        rest: Callable[[int], object],
        *,
        poll_ns: int = POLL_NS,
        stamps: bool = True,
        rates: dict[int, bytes] | None = None,
    ) -> None:
        self.adapter: Adapter | None = None
        self.sending = False  # the adapter has a frame and has not answered yet
        self.hears = False  # received frames are of the bus as it was last opened
        self.refused: Setup | None = None  # what the adapter cannot be set up as
        self._user = user
        self._now = now
        self._rest = rest
        self._poll_ns = poll_ns
        self._stamps = stamps
        self._rates = rates or {}
        self._stamped = ""  # serial number of the adapter that accepted Z1, which it stores
        self._accepted: tuple[int, int] | None = None
        self._poll_at_ns = NEVER
        self._open: Setup | None = None
        self._retry_at_ns = 0
        self._full = self._tries = self._failures = 0
        self._told = self._unsure = False
        self._row = 0

    def talk(self) -> Talk[None]:
        """All commands, until the adapter cannot be recovered."""
        self._open = self.refused = None
        self.hears = False
        self._accepted = None
        self._failures = 0
        met = False
        while True:
            try:
                if not met:
                    met = yield from self._greet()
                    if not met:
                        return
                yield from self._serve()
            except (NoAnswer, WrongAnswer) as error:
                self._failed(error)
                if self._failures >= _ATTEMPTS or (met and not (yield from self._recover())):
                    self._user.hopeless(_said(error))
                    return

    def _failed(self, error: NoAnswer | WrongAnswer) -> None:
        """Report an error, with one event until the next success."""
        self._failures += 1
        if not self._told:
            self._told = True
            wrong = isinstance(error, WrongAnswer)
            self._user.trouble(Trouble.WRONG_ANSWER if wrong else Trouble.NO_ANSWER, _said(error))

    def _went_well(self) -> None:
        self._failures, self._told = 0, False

    def _greet(self) -> Talk[bool]:
        """Greet the adapter; False if it is not the wanted one."""
        version = yield Ask(b"\r\r\rV", _VERSION, searches=True)
        dialect = recognised(version)
        for _ in range(_ATTEMPTS):  # an old answer may have come before
            if dialect is not None:
                break
            version = yield Ask(b"V", _VERSION, searches=True)
            dialect = recognised(version)
        if dialect is None:
            raise WrongAnswer(f"{version[:20]!r} to V")
        number = b""
        if dialect.numbered:
            number = yield self._asks(dialect, b"N", _NUMBER)
        text = "" if number == BELL else number[1:].decode()
        self.adapter = Adapter(dialect, version.decode("latin-1").strip(), text)
        yield self._asks(dialect, b"C")
        if dialect.stamps and self._stamps and self._stamped != (text or "?"):
            yield self._asks(dialect, b"Z1")
            self._stamped = text or "?"
        if self._user.met(self.adapter):
            return True
        self._user.hopeless(f"adapter {text} is another one")
        return False

    def _recover(self) -> Talk[bool]:
        """True once it answers again."""
        for _ in range(_ATTEMPTS):
            try:
                version = yield Ask(b"\r\r\rV", _VERSION, searches=True)
            except NoAnswer:
                continue
            if recognised(version) is not None:
                self._poll_at_ns = self._now()  # "or if you get an error back from the CAN232"
                self._unsure = True
                return True
        return False

    def _serve(self) -> Talk[None]:
        """Serve the user until an error occurs."""
        user = self._user
        while True:
            wanted = user.wanted
            if wanted is not self._open and (wanted is None or wanted is not self.refused):
                yield from self._change(wanted)
            elif self._open is None:
                self._rest(NEVER)
                yield None
            elif self._poll_at_ns <= self._now():
                yield from self._poll()
            elif (
                self._retry_at_ns <= self._now() and user.ready() and (text := user.next_frame()) is not None
            ):
                yield from self._send(text)
            else:
                waiting = user.next_frame() is not None and self._retry_at_ns > self._now()
                self._rest(min(self._poll_at_ns, self._retry_at_ns) if waiting else self._poll_at_ns)
                yield None

    # opening and closing

    def _change(self, wanted: Setup | None) -> Talk[None]:
        assert self.adapter is not None
        dialect = self.adapter.dialect
        if self._open is not None or self._unsure:
            was_open, self._open = self._open is not None, None
            self.hears = self.hears and was_open  # what it acknowledged before it takes the C is on its way
            yield self._asks(dialect, b"C")
            self.hears = self._unsure = False
            if was_open:
                self._user.closed()
        if wanted is None:
            self.refused = None
            return
        try:
            yield from self._set_up(dialect, wanted)
        except _Refused as refused:
            self.refused, self.hears = wanted, False
            self._user.trouble(Trouble.REFUSED, f"{self.adapter.version} refuses {refused}")
            return
        self._open, self.refused = wanted, None
        self._full = self._tries = self._retry_at_ns = 0
        self._poll_at_ns = self._now() + self._poll_ns if dialect.flags else NEVER
        self._went_well()
        self._user.opened()

    def _set_up(self, dialect: Dialect, wanted: Setup) -> Talk[None]:
        for command in self._rate(dialect, wanted):
            yield from self._insist(dialect, command)
        yield from self._filter(dialect, wanted)
        if wanted.listen_only and not dialect.listen:
            raise _Refused("to listen only")
        if dialect.normal:
            yield from self._insist(dialect, dialect.listen if wanted.listen_only else dialect.normal)
        alone = wanted.listen_only and not dialect.normal
        self.hears = True
        yield from self._insist(dialect, dialect.listen if alone else b"O")
        if dialect.flags:
            yield Ask(b"F", _FLAGS)

    def _filter(self, dialect: Dialect, wanted: Setup) -> Talk[None]:
        """Set M and m if needed; the values of an earlier program stay until then."""
        if not dialect.filters:
            if wanted.accept is not None:
                raise _Refused("acceptance filters")
            return
        code, mask = wanted.filter
        if (code, mask) != self._accepted:
            self._accepted = None
            yield from self._insist(dialect, b"M%08X" % code)
            yield from self._insist(dialect, b"m%08X" % mask)
            self._accepted = code, mask

    def _rate(self, dialect: Dialect, wanted: Setup) -> list[bytes]:
        commands = []
        rates = {**dialect.rates, **self._rates}
        if wanted.bit_rate in self._rates or wanted.btr is None or not dialect.registers:
            if wanted.bit_rate not in rates:
                raise _Refused(f"{wanted.bit_rate} bit/s; it has {', '.join(map(str, sorted(rates)))}")
            commands.append(b"S" + rates[wanted.bit_rate])
        elif wanted.btr in dialect.btr and not self._rates:
            commands.append(b"S" + dialect.btr[wanted.btr])
        else:
            commands.append(b"s" + wanted.btr.encode())
        if wanted.data_bit_rate is not None:
            if dialect.data_rates is None or wanted.data_bit_rate not in dialect.data_rates:
                raise _Refused(f"{wanted.data_bit_rate} bit/s for the data of CAN FD")
            commands.append(b"Y" + dialect.data_rates[wanted.data_bit_rate])
        return commands

    def _insist(self, dialect: Dialect, command: bytes) -> Talk[None]:
        answer = yield self._asks(dialect, command)
        if answer == BELL:
            raise _Refused(command.decode())

    @staticmethod
    def _asks(dialect: Dialect, text: bytes, answer: re.Pattern[bytes] | None = None) -> Ask:
        if not dialect.answers:
            return Ask(text, None)
        return Ask(text) if answer is None else Ask(text, answer)

    # frames and flags

    def _send(self, text: bytes) -> Talk[None]:
        assert self.adapter is not None
        user = self._user
        answer, self.sending = BELL, True
        try:
            answer = yield Ask(text, QUEUED if self.adapter.dialect.answers else None)
        except BaseException:  # also GeneratorExit: the adapter is gone
            self.sending = False
            user.given_up()
            raise
        self.sending = False
        if answer != BELL:
            self._full = self._tries = 0
            self._went_well()
            user.sent()
            if not self.adapter.dialect.answers:
                yield from self._take_turns()
            return
        flags = yield from self._poll()
        if flags & TRANSMIT_FULL:
            self._retry_at_ns = self._now() + min(_FULL_NS << self._full, _LONGEST_FULL_NS)
            self._full = min(self._full + 1, 10)
            return
        self._tries += 1
        if self._tries >= _ATTEMPTS and self._open is not None:
            self._tries = 0
            user.trouble(Trouble.REFUSED, f"refuses {text.decode()}")
            user.given_up()

    def _take_turns(self) -> Talk[None]:
        """After many frames without answers, rest, so that other work of the hub gets a turn."""
        self._row = (self._row + 1) % _IN_A_ROW
        if self._row == 0:
            self._rest(self._now())
            yield None

    def _poll(self) -> Talk[int]:
        """Send F and return the flags. If the channel turns out to be closed, it is opened again."""
        assert self.adapter is not None
        if not self.adapter.dialect.flags:
            self._poll_at_ns = NEVER
            return 0
        answer = yield Ask(b"F", _FLAGS)
        self._poll_at_ns = self._now() + self._poll_ns
        if answer == BELL:
            self._open = None
            self._failures += 1
            self._user.closed()
            if self._failures >= _ATTEMPTS:
                raise WrongAnswer("BELL to F")
            return 0
        flags = int(answer[1:], 16)
        self._went_well()
        self._unsure = False
        self._user.flags(flags)
        return flags


def _said(error: NoAnswer | WrongAnswer) -> str:
    return f"wrong answer: {error}" if isinstance(error, WrongAnswer) else f"no answer to {error}"
