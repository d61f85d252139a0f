"""The smallest cause of a failure: a run with as little as possible that still fails in the same way and place."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from canwire.campaigns.batches import Rules
from canwire.campaigns.campaign import MOST_RUNS, Campaign
from canwire.campaigns.change import Change, flip_in_words
from canwire.campaigns.junit import Played
from canwire.campaigns.limit import limit_of
from canwire.campaigns.loading import Script, script_of
from canwire.campaigns.parameters import Value
from canwire.campaigns.playing import CampaignRun
from canwire.campaigns.shrinking.fewer import fewest, least_prefix, simplest
from canwire.campaigns.shrinking.trials import Spent, Trials
from canwire.errors import BadValue
from canwire.lab.selection import FAULTS, FRAMES, KINDS, NOISE
from canwire.values.checks import whole

MOST_TRIALS = 500
_LEAST_LIMIT_S, _TIMES_AS_LONG = 5.0, 10
_MOST_LINES = 12
_MOST_UNKNOWN = 1 << 16
_UNITS = {FAULTS: "faults", NOISE: "bits of noise", FRAMES: "frames"}


@dataclass(frozen=True)
class SmallestCause:
    """A run that fails in the same way as another one, with fewer frames, faults and noise or simpler parameters.

    `line` is the command that repeats it. `given` are the changed parameters, `only` the numbers that take place of
    each kind ("frames", "faults", "noise"), `words` their descriptions; `flips` are inverted bits that replace noise,
    such as "can0:103:45" for bit 45 of the first frame 0x103. `counts` contains by kind how many take place, and how
    many did in the run that was shrunk (0 if its process ended). `trials` is the number of runs that were played to
    find it; `complete` is False if the trials were used up, so that a smaller cause may exist.
    """

    run: CampaignRun
    line: str
    given: dict[str, Value]
    only: dict[str, tuple[int, ...]]
    flips: tuple[str, ...]
    words: tuple[str, ...]
    counts: dict[str, tuple[int, int]]
    trials: int
    complete: bool

    def __str__(self) -> str:
        left = ", ".join(
            f"{f'{now} of {before}' if before else now} {_UNITS[kind]}"
            for kind, (now, before) in self.counts.items()
            if before or kind in self.only
        )
        end = "" if self.complete else "; no trial was left to look for a smaller one"
        head = f"still fails with {left or 'the same'}, found by {self.trials} runs{end}:"
        rest = len(self.words) - _MOST_LINES
        more = [f"  and {rest} more"] if rest > 0 else []
        return "\n".join([head, self.line, *(f"  {one}" for one in self.words[:_MOST_LINES]), *more])


def shrink_run(
    campaign: Campaign | str | Path,
    number: int,
    *,
    seed: int = 1,
    name: str = "",
    most_runs: int = MOST_TRIALS,
    time_limit: float | None = None,
) -> SmallestCause:
    """Find the smallest cause of run `number`, which fails, in a campaign that was started with `seed`.

    The run is played up to `most_runs` times, 2 to 1,000,000, each time with simpler parameters or without some of its
    faults, of the bits that noise inverts, or of the frames that are sent. A change is kept if the run still fails with
    the same verdict, by the same exception at the same line of the campaign's file. For the script, a frame that is
    left out counts as sent. The same call gives the same result. `time_limit` in s applies to each of these runs (None:
    ten times the duration of the run, at least 5 s). Raises BadValue if the run passes, or fails differently each time.
    """
    return smallest_cause(script_of(campaign, name), number, seed, most_runs, time_limit)


def smallest_cause(
    script: Script, number: int, seed: int, most_runs: int, time_limit: float | None
) -> SmallestCause:
    """Find the smallest cause of a run of a file that was already read."""
    rules = Rules(whole("seed", seed, 0, 1 << 63), limit_of(time_limit))
    made = script.load()
    trials = Trials(script, rules, whole("most_runs", most_runs, 2, 1_000_000))
    search = _Search(trials, made, Played(script.path, made.name, seed))
    with contextlib.closing(trials):
        return search.found(whole("run", number, 0, MOST_RUNS))


class _Search:
    """One search; `_best` is the smallest change found so far, `_run` its result."""

    def __init__(self, trials: Trials, campaign: Campaign, played: Played) -> None:
        self._trials = trials
        self._campaign = campaign
        self._played = played

    def found(self, number: int) -> SmallestCause:
        self._best = Change()
        self._first = self._run = first = self._trials.play(number, self._best)
        if first.passed:
            raise BadValue(
                f"run {number} with seed {self._played.seed} passes: there is no failure to shrink"
            )
        self._until_ns = (
            None if first.verdict in ("timeout", "crashed") else 4 * first.bus_time_ns + 1_000_000_000
        )
        if self._trials.rules.limit_s is None:
            limit_s = max(_LEAST_LIMIT_S, _TIMES_AS_LONG * first.wall_s)
            self._trials.close()
            self._trials.rules = self._trials.rules._replace(limit_s=limit_s)
        complete = True
        try:
            self._shrink()
        except Spent:
            complete = False
        return self._account(number, complete)

    def _shrink(self) -> None:
        before = None
        while before != self._best:
            before = self._best
            for name in self._campaign.space.names:
                value = self._run.parameters[name]
                simplest(self._campaign, name, value, partial(self._fails_with, name))
            for kind in (FAULTS, NOISE, FRAMES):
                fewest(self._items(kind), partial(self._fails_without, kind))
                if kind == NOISE:
                    self._pin()

    def _pin(self) -> None:
        """Replace noise by flips: noise bits are numbered in order, so leaving frames out would renumber them."""
        if not self._run.took.get(NOISE):
            return
        run = self._trials.play(self._first.number, self._best, words=True, until_ns=self._until_ns)
        found = [flip_in_words(words) for words in run.took[NOISE].values()]
        flips = [flip for flip in found if flip is not None]
        if len(flips) == len(found):
            pinned = self._best.with_only(NOISE, ())
            self._tried(replace(pinned, flips=(*self._best.flips, *flips)))

    def _items(self, kind: str) -> Sequence[int]:
        """Return the numbers that took place; if the run ended its process they are unknown, and prefixes are tried."""
        if self._run.took:
            return sorted(self._run.took[kind])
        if kind in self._best.only:
            return self._best.only[kind]
        count = least_prefix(_MOST_UNKNOWN, lambda part: self._fails_without(kind, part) is not None)
        return range(count) if count < _MOST_UNKNOWN else ()

    def _fails_with(self, name: str, value: Value) -> bool:
        return self._tried(self._best.with_value(name, value))

    def _fails_without(self, kind: str, part: Sequence[int]) -> Sequence[int] | None:
        """Play the run with only `part` of this kind; returns the numbers that took place, None if it fails no more."""
        if not self._tried(self._best.with_only(kind, part)):
            return None
        left = sorted(self._run.took.get(kind, part))
        self._best = self._best.with_only(kind, left)
        return left

    def _tried(self, change: Change) -> bool:
        """Whether the failure is the same; if so, this change is the best so far."""
        run = self._trials.play(self._first.number, change, until_ns=self._until_ns)
        if (run.verdict, run.place) != (self._first.verdict, self._first.place):
            return False
        self._best, self._run = change, run
        return True

    def _account(self, number: int, complete: bool) -> SmallestCause:
        own = self._first.parameters
        given = {name: value for name, value in self._best.given.items() if value != own[name]}
        best = replace(self._best, given=given)
        run = self._trials.play(number, best, words=True, until_ns=self._until_ns)
        words = [f"{kind} {at}: {text}" for kind in KINDS for at, text in run.took.get(kind, {}).items()]
        counts = {
            kind: (len(run.took.get(kind, best.only.get(kind, ()))), len(self._first.took.get(kind, ())))
            for kind in KINDS
        }
        line = f"{self._played.repetition(number)} {best.options()}".rstrip()
        return SmallestCause(
            run, line, given, dict(best.only), best.flips, tuple(words), counts, self._trials.count, complete
        )
