"""What each run of a campaign gets: the grid in order, draws from the run's own seed."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadValue, Draw, campaign
from canwire.campaigns.parameters import Space
from tests.cases import each


def test_the_last_list_changes_first() -> None:
    space = Space({"rate": [1, 2], "bit": range(3)})
    assert space.size == 6
    assert [tuple(space.at(run, 0).values()) for run in range(6)] == [
        (1, 0), (1, 1), (1, 2), (2, 0), (2, 1), (2, 2),
    ]  # fmt: skip
    assert space.at(6, 9) == space.at(0, 1)


@given(st.lists(st.integers(1, 5), min_size=1, max_size=4))
def test_a_grid_has_each_combination_once(lengths: list[int]) -> None:
    space = Space({f"p{place}": range(length) for place, length in enumerate(lengths)})
    assert len({tuple(space.at(run, 0).values()) for run in range(space.size)}) == space.size


DRAWS: list[tuple[Draw, Callable[[Any], bool]]] = [
    (Draw.uniform(-2, 5.5), lambda value: -2 <= value <= 5.5),
    (Draw.log_uniform(1e-9, 1e-3), lambda value: 1e-9 <= value <= 1e-3),
    (Draw.integer(3, 5), lambda value: value in (3, 4, 5) and isinstance(value, int)),
    (Draw.choice(["a", "b"]), lambda value: value in ("a", "b")),
]


@each(("draw", "within"), DRAWS, ids=lambda one: getattr(one, "kind", ""))
def test_draws_stay_within_and_differ(draw: Draw, within: Callable[[Any], bool]) -> None:
    values = [draw.drawn(random.Random(seed)) for seed in range(200)]
    assert all(map(within, values))
    assert len(set(values)) > 1


def test_a_logarithmic_draw_visits_each_order_of_magnitude() -> None:
    draw, source = Draw.log_uniform(1e-6, 1e-3), random.Random(1)
    small = sum(float(draw.drawn(source)) < 1e-5 for _ in range(3000))
    assert 800 < small < 1200


def test_draws_belong_to_the_run_s_seed() -> None:
    space = Space({"noise": Draw.uniform(0, 1), "place": Draw.integer(0, 1 << 40)})
    assert space.at(5, 77) == space.at(5, 77)
    assert space.at(5, 77) != space.at(5, 78)


@each(
    ("made", "said"),
    [
        (lambda: Draw.uniform(2, 1), "from 2 to 1: nothing lies between"),
        (lambda: Draw.log_uniform(0, 1), "begins above 0"),
        (lambda: Draw.integer(1.5, 2), "must be int, not float"),
        (lambda: Draw.choice([]), "no values"),
        (lambda: campaign(bit=[]), "bit: no values"),
        (lambda: campaign(bit="abc"), "must be a list, a range or a Draw"),
        (lambda: campaign(bit=[object()]), "must be a number, a string"),
        (lambda: campaign(bit=7), "must be a list, a range or a Draw"),
    ],
)
def test_what_cannot_be_varied_is_refused(made: Callable[[], object], said: str) -> None:
    with pytest.raises((BadValue, TypeError), match=said):
        made()


def test_function_and_parameters_must_fit() -> None:
    with pytest.raises(BadValue, match=r"lonely\(\) does not take bit"):

        @campaign(bit=[1])
        def lonely(lab: object) -> None: ...

    with pytest.raises(BadValue, match=r"eager\(\) needs rate too"):

        @campaign(bit=[1])
        def eager(lab: object, bit: int, rate: int) -> None: ...


def test_seeds_of_runs_differ_and_stay() -> None:
    @campaign()
    def some(lab: object) -> None: ...

    assert len({some.seed_of(run, seed) for run in range(500) for seed in range(4)}) == 2000
    assert some.seed_of(4711, 1) == 2979953101884597604
