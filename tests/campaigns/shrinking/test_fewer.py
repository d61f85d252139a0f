"""Fewer items and nearer values, for failures of which everything is known."""

from __future__ import annotations

import random
from collections.abc import Sequence

import pytest

from canwire import BadValue, Draw
from canwire.campaigns.campaign import Campaign, campaign
from canwire.campaigns.change import Change, flip_in_words, flip_of, numbers_in_words, numbers_of_words
from canwire.campaigns.parameters import Value
from canwire.campaigns.shrinking.fewer import fewest, least_prefix, simplest
from tests.cases import each

pytestmark = pytest.mark.conforms("N-60")


@each("causes", [[], [0], [99], [3, 50], [0, 1, 2, 97, 98, 99], list(range(0, 100, 9))])
def test_the_causes_are_left(causes: list[int]) -> None:
    tried = 0

    def fails(part: Sequence[int]) -> Sequence[int] | None:
        nonlocal tried
        tried += 1
        return part if set(causes) <= set(part) else None

    assert fewest(range(100), fails) == causes
    assert tried < 20 + 20 * len(causes)


def test_no_single_one_can_be_left_out_where_causes_replace_each_other() -> None:
    dice = random.Random(5)
    for _ in range(50):
        pairs = [set(dice.sample(range(30), 2)) for _ in range(6)]

        def fails(part: Sequence[int], pairs: list[set[int]] = pairs) -> Sequence[int] | None:
            return part if any(pair <= set(part) for pair in pairs) else None

        found = fewest(range(30), fails)
        assert set(found) in pairs


def test_what_did_not_take_place_is_left_out_too() -> None:
    assert fewest(range(8), lambda part: [one for one in part if one < 3] if 2 in part else None) == [2]
    assert fewest([], lambda part: None) == []


def test_prefixes() -> None:
    assert least_prefix(1000, lambda part: 17 in part) == 18
    assert least_prefix(10, lambda part: 17 in part) == 10


def _made() -> Campaign:
    @campaign(
        rate=[500, 250, 125], size=Draw.integer(2, 900), noise=Draw.log_uniform(1e-6, 1e-1),
        way=Draw.choice(["x", "y"]), depth=range(9), gap=Draw.uniform(-1.0, 4.0),
    )  # fmt: skip
    def many(
        lab: object, rate: int, size: int, noise: float, way: str, depth: int = 3, gap: float = 1.5
    ) -> None:
        """Nothing."""

    return many


@each(
    ("name", "value", "fails", "found"),
    [
        ("rate", 125, lambda rate: True, 500),
        ("rate", 125, lambda rate: rate < 500, 250),
        ("size", 777, lambda size: size >= 42, 42),
        ("size", 777, lambda size: True, 2),
        ("noise", 0.0123456, lambda noise: noise > 0.001, 0.0011),
        ("noise", 0.0123456, lambda noise: True, 1e-6),
        ("way", "y", lambda way: True, "x"),
        ("way", "y", lambda way: way == "y", "y"),
        ("depth", 8, lambda depth: depth > 4, 5),
        ("depth", 0, lambda depth: True, 3),
        ("depth", 77, lambda depth: True, 77),
        ("gap", 3.9, lambda gap: True, 1.5),
        ("gap", 3.9123, lambda gap: gap > 3.0, 3.1),
    ],
)
def test_values_come_near_to_their_defaults(name: str, value: Value, fails: object, found: Value) -> None:
    assert callable(fails)
    assert simplest(_made(), name, value, fails) == found


def test_numbers_in_words_are_read_back() -> None:
    for numbers in [(), (0,), (3, 7, 8, 9), (1, 2, 4, 5, 6, 20)]:
        assert numbers_of_words(numbers_in_words(numbers)) == numbers
    for wrong in ("", "a", "3-", "-3", "1,,2"):
        with pytest.raises(BadValue, match=r"such as 3,7-9, or none"):
            numbers_of_words(wrong)


def test_values_as_text_are_of_the_run_s_own_types() -> None:
    own: dict[str, Value] = {"a": 1, "b": 0.5, "c": True, "d": "text"}
    given = {"a": "-7", "b": "3", "c": "False", "d": "8"}
    assert Change.of(given, None).parameters(own) == {"a": -7, "b": 3.0, "c": False, "d": "8"}
    assert Change.of({"a": "1.5"}, {"frames": [2, 1]}).options() == "--set a=1.5 --only frames=1-2"
    for wrong in ({"a": "x"}, {"c": "yes"}, {"e": 1}):
        with pytest.raises(BadValue):
            Change.of(wrong, None).parameters(own)
    with pytest.raises(BadValue, match="one of frames, faults, noise"):
        Change.of(None, {"bits": [1]})
    with pytest.raises(BadValue, match="such as can0:103:45"):
        Change.of(None, None, ["can0:1:45"])


def test_a_bit_of_noise_is_a_flip() -> None:
    assert flip_in_words("can0: bit 45 of 103#1122 from a at 3 ns") == "can0:103:45"
    assert flip_in_words("can0: bit 9 of 18FEF100## from a at 3 ns") == "can0:18FEF100:9"
    assert flip_in_words("can0: bit 9 of a frame from a at 3 ns") is None
    assert flip_of("a:b:18FEF100:9") == ("a:b", 0x18FEF100, True, 9)
