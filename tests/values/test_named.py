"""Enumerations show their names, and stay numbers."""

from __future__ import annotations

import json

import pytest

import canwire
from canwire import ErrorState, Feature


@pytest.mark.finding("newcomer F11")
def test_states_print_their_names() -> None:
    state = ErrorState.BUS_OFF
    assert (str(state), f"{state}", f"{state:>9}", f"{state}"[:3]) == (
        "BUS_OFF",
        "BUS_OFF",
        "  BUS_OFF",
        "BUS",
    )
    assert (state, f"{state:d}", f"{state:#x}", json.dumps(state)) == (3, "3", "0x3", "3")


def test_flags_print_theirs() -> None:
    both = Feature.REMOTE_FRAMES | Feature.SCHEDULER
    assert str(both) == "REMOTE_FRAMES|SCHEDULER"
    assert (str(Feature(0)), f"{both:#x}", f"{Feature(0):>2}") == ("0", "0x84", " 0")


def test_so_do_all_public_ones() -> None:
    kinds = [
        value
        for value in (getattr(canwire, name) for name in canwire.__all__)
        if isinstance(value, type) and issubclass(value, int) and hasattr(value, "__members__")
    ]
    assert len(kinds) > 10
    assert [kind for kind in kinds if [str(one) for one in kind] != [one.name for one in kind]] == []
