"""The lower tester: plays levels to a controller under test, and holds what that drives against what it must drive.

A `Tester` is filled like a tape: `lt` and `iut` send frames, `bits` anything else. Two rows run side by side, one
cell a bit: what the tester puts in front of the controller ("0" dominant, "-" nothing, "1" recessive whatever the
controller drives) and what the controller has to drive ("0", "1"). `play` runs both, and fails at the first
picosecond where the controller drives something else. `check` marks are looked at when the tape gets there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Self

from canwire.bus.can.stimulus import FREE, Stimulus
from tests.iso16845.frames import Bits, Spec, lay_out
from tests.iso16845.iut import Iut, frame_of

_LEVELS = {"0": 0, "1": 1, "-": FREE}
SETTLING = 15  # bits behind the tape in which nothing more may happen


class Tester:
    """One elementary test. Times are picoseconds since the first cell; `frame` is the last one laid out."""

    def __init__(self, kind: str, iut: Iut | None = None) -> None:
        self.iut = iut or Iut(kind)
        self.n_ps = self.iut.timing.bit_time_ps
        self.d_ps = self.iut.data.bit_time_ps
        self.tq = self.iut.timing.quantum_ps
        self.sample_ps = self.iut.timing.sample_time_ps
        self.fast_sample_ps = self.iut.data.sample_time_ps
        self.ps2 = self.n_ps - self.sample_ps
        self.fast_ps2 = self.d_ps - self.fast_sample_ps
        self.now_ps = 0
        self.frame = Bits(Spec(0))
        self.starts: list[int] = []
        self._played: list[tuple[int, int]] = []
        self._forced: list[tuple[int, int, int]] = []
        self._driven: list[tuple[int, int]] = []
        self._seen: list[tuple[int, int]] = []
        self._checks: list[tuple[int, Callable[[], None]]] = []
        self._sends: list[tuple[int, Spec]] = []
        self._level = 1
        self.single_shot = False

    # the tape

    def bits(self, lt: str, iut: str | None = None, *, bit_ps: int = 0) -> Self:
        """Cells of one nominal bit (or `bit_ps`); `iut` left out: recessive."""
        iut = "1" * len(lt) if iut is None else iut
        assert len(lt) == len(iut)
        for level, driven in zip(lt, iut, strict=True):
            self._cell(level, driven, bit_ps or self.n_ps)
        return self

    def recessive(self, count: int) -> Self:
        """Nobody drives anything."""
        return self.bits("-" * count)

    def dominant(self, count: int) -> Self:
        """The tester alone drives dominant."""
        return self.bits("0" * count)

    def flag(self, count: int = 6) -> Self:
        """The controller drives an active error flag, or an overload flag."""
        return self.bits("-" * count, "0" * count)

    def passive_flag(self) -> Self:
        return self.recessive(6)

    def between(self, count: int = 8 + 3) -> Self:
        """Delimiter and intermission."""
        return self.recessive(count)

    def lt(
        self,
        frame: Spec | Bits,
        *,
        change: Mapping[int, str] | None = None,
        until: int | None = None,
        since: int = 0,
        ack: bool = True,
        drives: str = "",
        lengths: Mapping[int, int] | None = None,
    ) -> Self:
        """The tester sends a frame: its bits from `since` up to and including `until`, where an error ends it.

        `change` has other cells for some bits, `lengths` how much longer (ps; < 0: shorter) some are. The controller
        drives `drives` first, and acknowledges if `ack`.
        """
        return self._frame(
            frame, change or {}, until, since, sends=False, ack=ack, drives=drives, lengths=lengths
        )

    def sends(
        self,
        frame: Spec | Bits,
        *,
        change: Mapping[int, str] | None = None,
        until: int | None = None,
        since: int = 0,
        ack: bool = True,
        ask: bool = True,
        lengths: Mapping[int, int] | None = None,
    ) -> Self:
        """The controller sends a frame, the tester acknowledges if `ack`; `ask` puts it into the queue at SOF."""
        if ask:
            self.ask(frame.spec if isinstance(frame, Bits) else frame)
        return self._frame(frame, change or {}, until, since, sends=True, ack=ack, lengths=lengths)

    def ask(self, spec: Spec) -> Self:
        """The controller is asked to send this from now on."""
        self._sends.append((self.now_ps, spec))
        return self

    def _frame(
        self, frame: Spec | Bits, change: Mapping[int, str], until: int | None, since: int, *, sends: bool, ack: bool,
        drives: str = "", lengths: Mapping[int, int] | None = None,
    ) -> Self:  # fmt: skip
        bits = frame if isinstance(frame, Bits) else lay_out(frame)
        self.frame = bits
        self.starts = []
        last = len(bits.levels) - 1 if until is None else until
        ack_slot = bits.ack
        for k in range(last + 1):
            self.starts.append(self.now_ps)
            if k < since:
                continue
            level, driven = (bits.levels[k], "1") if not sends else ("-", bits.levels[k])
            level = "-" if level == "1" else level
            if k < len(drives):
                driven = drives[k]
            if k == ack_slot and ack:
                level, driven = ("0", "1") if sends else ("-", "0")
            length_ps = self._length(bits, k, failing=k == until) + (lengths or {}).get(k, 0)
            self._cell(change.get(k, level), driven, length_ps)
        self.starts.append(self.now_ps)
        return self

    def _length(self, bits: Bits, k: int, *, failing: bool) -> int:
        """A bit's length: rates change at the sample points of BRS, of the CRC delimiter, or where an error is seen."""
        fast = bits.fast[k]
        following = k + 1 < len(bits.fast) and bits.fast[k + 1] and not failing
        if bits.names[k] == "CRC DEL":
            following = False
        before = self.fast_sample_ps if fast else self.sample_ps
        return before + (self.fast_ps2 if following else self.ps2)

    def _cell(self, level: str, driven: str, length_ps: int) -> None:
        self._played.append((self.now_ps, _LEVELS[level]))
        self._drive(int(driven), self.now_ps)
        self.now_ps += length_ps

    def _drive(self, level: int, at_ps: int) -> None:
        if level != self._level:
            self._driven.append((at_ps, level))
            self._level = level

    # finer than a bit

    def force(self, level: str, start_ps: int, width_ps: int) -> Self:
        """Over what the tape says, the tester puts a level in front of the controller for a while."""
        self._forced.append((start_ps, start_ps + width_ps, _LEVELS[level]))
        return self

    def drives(self, start_ps: int, width_ps: int) -> Self:
        """The controller drives dominant in this time, beside what the tape says."""
        self._driven += [(start_ps, 0), (start_ps + width_ps, 1)]
        return self

    def skip(self, ps: int) -> Self:
        """Everything behind happens so much later (earlier if negative)."""
        if ps > 0:
            self._played.append((self.now_ps, FREE))
        self.now_ps += ps
        return self

    # what else must be so

    def counters(self, tec: int | None = None, rec: int | None = None) -> Self:
        """At this point of the tape the counters have these values."""
        where = self.now_ps

        def look() -> None:
            found = (self.iut.tec if tec is not None else None, self.iut.rec if rec is not None else None)
            assert found == (tec, rec), f"TEC, REC at bit {where / self.n_ps:.1f}"

        return self.check(look)

    def check_at(self, bit: int, *, tec: int | None = None, rec: int | None = None) -> Self:
        """Counters as a bit of the last frame begins: behind that bit's predecessor."""
        now_ps, self.now_ps = self.now_ps, self.starts[bit]
        self.counters(tec, rec)
        self.now_ps = now_ps
        return self

    def check(self, look: Callable[[], None]) -> Self:
        self._checks.append((self.now_ps, look))
        return self

    # running it

    def play(self, *, received: list[Spec] | None = None, settling: int = SETTLING) -> Iut:
        """Run the tape and `settling` recessive bits more; `received` (None: unchecked) is what it hands up."""
        self.recessive(settling)
        iut = self.iut
        timeline = iut.timeline
        timeline.run_until(timeline.now_ns + 2 * self.n_ps // 1000)  # an earlier tape has come to rest
        start_ps = timeline.now_ns * 1000
        iut.bus.bitwise = True
        iut.bus.bits.capture = lambda at_ps, level: self._seen.append((at_ps - start_ps, level))
        times, levels = self._stimulus(start_ps)
        iut.bus.stimulate(Stimulus(times, levels, [iut.line.controller]))
        for at_ps, spec in self._sends:
            timeline.at(
                (start_ps + at_ps) // 1000, lambda spec=spec: iut.send(spec, single_shot=self.single_shot)
            )
        for at_ps, look in sorted(self._checks, key=lambda check: check[0]):
            timeline.run_until((start_ps + at_ps) // 1000)
            look()
        timeline.run_until((start_ps + self.now_ps) // 1000)
        self._compare()
        if received is not None:
            found = iut.received()
            assert found == [frame_of(spec) for spec in received]
        return iut

    def _stimulus(self, start_ps: int) -> tuple[list[int], list[int]]:
        edges = sorted({at for at, _ in self._played} | {at for one in self._forced for at in one[:2]})
        changes: list[tuple[int, int]] = []
        position, base = 0, FREE
        for at in edges:
            while position < len(self._played) and self._played[position][0] <= at:
                base = self._played[position][1]
                position += 1
            over = [level for begin, end, level in self._forced if begin <= at < end]
            level = over[-1] if over else base
            if not changes or changes[-1][1] != level:
                changes.append((start_ps + at, level))
        changes.append((start_ps + self.now_ps, FREE))
        return [at for at, _ in changes], [level for _, level in changes]

    def _compare(self) -> None:
        until = self.now_ps
        seen = [(at, level) for at, level in self._seen if at < until]
        self._driven.sort()
        assert self._in_bits(seen) == self._in_bits(self._driven), "what the controller drove, in bits"
        assert seen == self._driven

    def _in_bits(self, changes: list[tuple[int, int]]) -> list[tuple[float, int]]:
        """Times as nominal bits, for people."""
        return [(round(at / self.n_ps, 2), level) for at, level in changes]
