"""Plain lines of candump logs are read by numpy, all of them: a line that takes the slow way is thirty times slower."""

from __future__ import annotations

from io import BytesIO

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from canwire import Frame, LogLine, format_log_line
from canwire.logs.candump.fast import plain_lines
from canwire.logs.candump.reading import entries, read
from canwire.logs.source import Source

lines = st.builds(
    lambda time_us, name, extended, id, data, direction: format_log_line(
        LogLine(
            time_us * 1000,
            name,
            Frame(id if extended else id & 0x7FF, data, extended=extended, timestamp_ns=time_us * 1000),
            direction,
        )
    ),
    st.integers(0, 2_000_000_000_000_000),
    st.text("abcdefvxyz0123456789-_", min_size=1, max_size=15),
    st.booleans(),
    st.integers(0, 0x1FFFFFFF),
    st.binary(max_size=8),
    st.sampled_from(("R", "T", None)),
)


@settings(max_examples=60, deadline=None)
@given(st.lists(lines, min_size=1, max_size=40), st.sampled_from(("\n", "\r\n")))
def test_plain_lines_all_go_the_quick_way(texts: list[str], end: str) -> None:
    block = end.join([*texts, ""]).encode()
    source = Source("x.log", BytesIO(block))
    records, others, count = plain_lines(block, source)
    assert (len(records), others, count) == (len(texts), [], len(texts))


@settings(max_examples=60, deadline=None)
@given(st.lists(lines | st.sampled_from(["rubbish", "", "(1.0) can0 123#R", "(1.0) can0 123##1AA",
                                           "(1.5) x 7FF#0", "(1.000000)  can0 123#",
                                           "(1.000000) abcdefghijklmnopq 123#11 T"]),
                min_size=1, max_size=30))  # fmt: skip
def test_both_ways_read_the_same(texts: list[str]) -> None:
    block = "\n".join(texts).encode()
    one, two = Source("x.log", BytesIO(block)), Source("x.log", BytesIO(block))
    quick = [entry for batch in read(two) for entry in batch]
    assert list(entries(one)) == quick
    assert one.faults == two.faults


@pytest.mark.parametrize(
    "text",
    [
        "(1.0000001) can0 123#",
        "(1.000000) can0 12#",
        "(1.000000) can0 923#",
        "(1.000000)can0 123#",
        "x#y)",
        "(1.000000)  can0 123#",
        "(1.000000) abcdefghijklmnopq 123#",
        "(1.000000) can0 123# R ",
    ],
)
def test_what_is_not_plain_is_handed_back(text: str) -> None:
    _, others, count = plain_lines(f"{text}\n".encode(), Source("x.log", BytesIO()))
    assert (others, count) == ([(0, 0, text.encode())], 1)


@pytest.mark.parametrize("text", ["(1.000000) can0 123#", "(0.500000) c 12345678#11 R"])
def test_a_short_line_at_the_beginning_goes_the_quick_way(text: str) -> None:
    """The seconds of other lines have ten digits, which would begin before the block here."""
    records, others, _ = plain_lines(f"{text}\n".encode(), Source("x.log", BytesIO()))
    assert (len(records), others) == (1, [])
