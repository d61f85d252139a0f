"""Colours: on terminals, unless the user does not want them."""

from __future__ import annotations

import io
import re

import pytest

from canwire.commands import main
from canwire.commands.shell.colour import GREEN, RED, has_colours, painted

pytestmark = pytest.mark.finding("newcomer F13")


class Terminal(io.StringIO):
    """What people look at."""

    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def _plain_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")


def test_only_terminals_have_colours(monkeypatch: pytest.MonkeyPatch) -> None:
    assert has_colours(Terminal())
    assert not has_colours(io.StringIO())
    monkeypatch.setenv("TERM", "dumb")
    assert not has_colours(Terminal())


def test_no_color_is_respected(monkeypatch: pytest.MonkeyPatch) -> None:
    assert painted("bus off", RED, Terminal()) == "\x1b[31mbus off\x1b[0m"
    assert painted("as it is", "", Terminal()) == "as it is"
    monkeypatch.setenv("NO_COLOR", "1")
    assert painted("bus off", RED, Terminal()) == "bus off"
    monkeypatch.setenv("NO_COLOR", "")  # as if it were not there, says no-color.org
    assert painted("bus off", RED, Terminal()) == "\x1b[31mbus off\x1b[0m"


def test_states_of_devices_are_coloured_and_aligned(
    hub_address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main(["up", "can0", "--hub", hub_address]) == 0
    shown = {}
    for kind in (Terminal, io.StringIO):
        screen = kind()
        monkeypatch.setattr("sys.stdout", screen)
        assert main(["devices", "--hub", hub_address]) == 0
        shown[kind] = screen.getvalue()
    monkeypatch.undo()
    assert f"\x1b[{GREEN}merror active" in shown[Terminal]
    assert re.sub(r"\x1b\[\d*m", "", shown[Terminal]) == shown[io.StringIO]
    assert "\x1b" not in shown[io.StringIO]
