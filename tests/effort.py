"""How much chance a test plays through: what each run shows, the interpreted core's share of it, or for whoever asks.

The usual run takes the same examples each time, so that it fails only over what has changed. The interpreted core runs
the very same source some thirty times slower: what only that form can show (types that C checks, integers that do not
wrap, exceptions where C has none) shows in every frame, and it plays an eighth of the scenarios. With
`--hypothesis-profile=thorough` there are ten times as many, of hypothesis with other draws in each run.
"""

from __future__ import annotations

import hypothesis

from canwire import core_mode

USUAL, THOROUGH = "canwire", "thorough"
EXAMPLES = 30  # of a rule without a state; who needs more has @examples(N)
_TIMES_THOROUGH = 10
_SHARE_INTERPRETED = 8
_SLOW = [hypothesis.HealthCheck.too_slow]  # a clone's first draw of text computes tables for half a second


def register_profiles() -> None:
    """A busy machine is no bug, so slow examples and slow draws are none: timing belongs to the benchmarks."""
    usual = EXAMPLES if core_mode() == "compiled" else EXAMPLES // 3
    hypothesis.settings.register_profile(
        USUAL, deadline=None, max_examples=usual, derandomize=True, suppress_health_check=_SLOW
    )
    many = EXAMPLES * _TIMES_THOROUGH
    hypothesis.settings.register_profile(
        THOROUGH, deadline=None, max_examples=many, derandomize=False, suppress_health_check=_SLOW
    )
    hypothesis.settings.load_profile(USUAL)


def scaled(usual: int) -> int:
    """So many in this run, where the usual one has `usual`."""
    if hypothesis.settings.default.max_examples > EXAMPLES:  # type: ignore[union-attr]
        return usual * _TIMES_THOROUGH
    if core_mode() == "uncompiled":
        return -(-usual // _SHARE_INTERPRETED)
    return usual


def examples(usual: int, *, same_fixtures: bool = False) -> hypothesis.settings:
    """A decorator: so many examples in the usual run; for what has a state, or cases that few draws meet.

    With `same_fixtures` all examples may share what a fixture made for the test.
    """
    checks = [*_SLOW, *([hypothesis.HealthCheck.function_scoped_fixture] if same_fixtures else [])]
    return hypothesis.settings(max_examples=scaled(usual), suppress_health_check=checks)


def seeds(first: int, usual: int) -> range:
    """Seeds of random scenarios, from `first` on."""
    return range(first, first + scaled(usual))
