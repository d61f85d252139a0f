"""What controllers can be set to: legal values exist, others are refused with their name and range."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadValue, ControllerOptions, DelayCompensation
from tests.cases import each

times = st.floats(0, 100_000) | st.integers(0, 100_000)
loops = st.floats(0, 2_000) | st.integers(0, 2_000)
wrong_times = (
    st.floats(max_value=-1e-9, allow_nan=False)
    | st.floats(min_value=100_000, exclude_min=True)
    | st.integers(max_value=-1)
    | st.integers(min_value=100_001)
    | st.sampled_from([math.nan, True, "5", b"", None])
)
compensations = st.builds(DelayCompensation, st.none() | times, times) | st.builds(
    lambda offset: DelayCompensation(offset, measured=False), times
)
options = st.builds(
    ControllerOptions,
    loops,
    st.none() | compensations,
    st.booleans(),
    st.booleans(),
    st.just(True),
    st.booleans(),
) | st.builds(ControllerOptions, loops, st.none() | compensations, protocol_exception=st.just(False))


@given(options, options)
def test_a_program_decides_but_for_what_is_a_fact_of_the_board(
    asked: ControllerOptions, board: ControllerOptions
) -> None:
    both = asked.on_board(board)
    assert both.loop_delay_ns == (asked.loop_delay_ns or board.loop_delay_ns)
    assert both.fd_tolerant == (asked.fd_tolerant or (board.fd_tolerant and asked.protocol_exception))
    same = replace(both, loop_delay_ns=asked.loop_delay_ns, fd_tolerant=asked.fd_tolerant)
    assert same == asked
    assert asked.on_board(asked) == asked


@given(options)
def test_what_is_unusual_has_its_name(asked: ControllerOptions) -> None:
    usual = ControllerOptions()
    assert usual.unusual() == []
    changes = {name: getattr(asked, name) for name in asked.unusual()}
    assert replace(usual, **changes) == asked
    assert all(getattr(usual, name) != value for name, value in changes.items())


@given(wrong_times)
def test_times_out_of_range(value: object) -> None:
    with pytest.raises(BadValue, match=r"filter_ns .*: nanoseconds from 0 to 100,000"):
        DelayCompensation(filter_ns=value)  # type: ignore[arg-type]
    with pytest.raises(BadValue, match=r"loop_delay_ns .*: nanoseconds from 0 to 2,000"):
        ControllerOptions(loop_delay_ns=value)  # type: ignore[arg-type]
    if value is not None:
        with pytest.raises(BadValue, match=r"offset_ns .*: nanoseconds from 0 to 100,000"):
            DelayCompensation(value)  # type: ignore[arg-type]


@each(
    ("make", "message"),
    [
        (lambda: ControllerOptions(2000.1), "loop_delay_ns 2000.1: nanoseconds from 0 to 2,000"),
        (lambda: ControllerOptions(edge_filter=1), "edge_filter 1: True or False"),
        (lambda: ControllerOptions(restricted="yes"), "restricted 'yes': True or False"),
        (
            lambda: ControllerOptions(compensation=200),
            "compensation 200: a DelayCompensation, or None for none",
        ),
        (
            lambda: ControllerOptions(fd_tolerant=True, protocol_exception=False),
            "fd_tolerant True: it is a protocol exception, which protocol_exception switches off",
        ),
        (lambda: DelayCompensation(measured=0), "measured 0: True or False"),
        (
            lambda: DelayCompensation(measured=False),
            "offset_ns None: a second sample point that is not measured needs its offset_ns",
        ),
        (
            lambda: DelayCompensation(100, 50, measured=False),
            "filter_ns 50: only a measured delay has a filter window",
        ),
    ],
)
def test_what_is_refused(make: object, message: str) -> None:
    with pytest.raises(BadValue) as refused:
        make()  # type: ignore[operator]
    assert str(refused.value) == message
