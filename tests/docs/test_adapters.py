"""The table of interfaces in docs/adapters.md: all there are, and tests that are there."""

from __future__ import annotations

import logging
import re
from pathlib import Path

import pytest

from canwire.commands.share import KINDS
from canwire.drivers.python_can.backends import BACKENDS
from canwire.drivers.python_can.opening import Setup, open_bus
from canwire.drivers.python_can.port import parse_port
from canwire.drivers.python_can.reasons import NEEDS, known_interfaces, reason
from tests.drivers.outside_bench import TIMING

pytest.importorskip("can")
ROOT = Path(__file__).parents[2]
ROW = re.compile(r"\| (`.+`) \| (.+) \| (.+) \| (.+) \|")
NO_REASON = {"virtual", "udp_multicast", "canwire", "slcan"}  # they open here; slcan is refused


def rows() -> list[tuple[list[str], str, list[str]]]:
    """Names of interfaces, what they were tried with, and the tests that show it."""
    text = (ROOT / "docs" / "adapters.md").read_text(encoding="utf-8")
    table = text[text.index("## Tests of the interfaces") :]
    found = (ROW.fullmatch(line) for line in table.splitlines())
    return [
        (re.findall(r"`(\w+)`", one[1]), one[3], re.findall(r"`([\w/.]+)`", one[4])) for one in found if one
    ]


def test_each_interface_is_in_the_table_once() -> None:
    named = [name for names, _, _ in rows() for name in names]
    assert sorted(named) == sorted({*named})
    assert {*named} == {*known_interfaces(), *BACKENDS, *(kind for kind in KINDS if kind != "python-can")} - {
        "slcan-fd"
    }


def test_the_tests_are_there() -> None:
    named = [test for _, _, tests in rows() for test in tests]
    assert len(named) >= len(rows())
    assert [one for one in named if not (ROOT / "tests" / one).exists()] == []


@pytest.mark.parametrize("interface", sorted({*known_interfaces()} - NO_REASON))
def test_what_keeps_each_interface_from_opening_is_named(interface: str) -> None:
    """Here nobody has an adapter, nor a driver of a maker's: each says what it needs, or what is not there."""
    logging.getLogger("can").addHandler(logging.NullHandler())
    port = parse_port(f"{interface}/0")
    try:
        open_bus(port, Setup(TIMING, None, False)).shutdown()
    except Exception as error:  # python-can's many kinds
        told = reason(port, error)
    else:
        pytest.skip(f"{interface} opens here: this machine has such an adapter")
    needs = NEEDS.get(interface)
    words = [word for word in (needs.package, needs.driver) if word] if needs else []
    assert any(
        word in told
        for word in (*words, f"no {interface}/0; found: ", "modprobe can_raw", "?host=...&port=...")
    ), told
