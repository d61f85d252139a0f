"""What public calls make sure of before they hand a value on."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.errors import BadValue
from canwire.values.checks import LONGEST_NS, finite, instance, nanoseconds, octets, shown, whole
from tests.cases import each


@given(st.integers(), st.integers(), st.integers())
def test_a_whole_number_is_within_its_bounds_or_refused(value: int, one: int, other: int) -> None:
    lowest, highest = sorted((one, other))
    if lowest <= value <= highest:
        assert whole("count", value, lowest, highest) == value
    else:
        with pytest.raises(BadValue, match="count"):
            whole("count", value, lowest, highest)


@each("value", [np.int64(7), np.uint8(7), True + 6])
def test_numpys_integers_are_whole(value: int) -> None:
    assert whole("count", value, 0, 10) == 7


@each("value", [1.0, "7", None, b"7", int])
def test_nothing_else_is(value: object) -> None:
    with pytest.raises(TypeError, match="must be int"):
        whole("count", value, 0, 10)  # type: ignore[arg-type]


@pytest.mark.parametrize("value", [0.25, Fraction(1, 4), np.float32(0.25), np.float64(0.25)])
def test_seconds_become_nanoseconds(value: float) -> None:
    assert nanoseconds("timeout", value) == 250_000_000


@pytest.mark.parametrize("value", [-1e-9, float("nan"), float("inf"), 1e300, 10**400, LONGEST_NS])
def test_spans_that_cannot_be(value: float) -> None:
    with pytest.raises(BadValue, match=r"timeout .*at most 146 years"):
        nanoseconds("timeout", value)


def test_numbers_within_bounds() -> None:
    assert finite("length_m", 3, 0, 10) == 3.0
    with pytest.raises(BadValue, match="length_m -1: from 0 to 10"):
        finite("length_m", -1, 0, 10)
    with pytest.raises(TypeError, match="length_m '3': must be int or float, not str"):
        finite("length_m", "3", 0, 10)  # type: ignore[arg-type]


def test_a_class_is_told_from_what_it_makes() -> None:
    with pytest.raises(TypeError, match="script <class 'int'>: must be str, not the class int"):
        instance("script", int, str)


def test_buffers_of_any_shape() -> None:
    assert octets("data", memoryview(b"1a2b")[::2]) == b"12"
    with pytest.raises(TypeError, match="data 5: must be bytes or bytearray or memoryview, not int"):
        octets("data", 5)  # type: ignore[arg-type]


def test_values_are_shown_short() -> None:
    assert shown(10**1000) == "of 1001 digits"
    assert len(shown("x" * 1000)) == 60
