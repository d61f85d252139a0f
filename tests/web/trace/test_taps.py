"""Whether a line is recorded now, which is all that a viewer may call listening."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

import canwire
from canwire import LinePlace, every_line
from canwire.web.link import HubLink
from canwire.web.trace import taps as taps_module
from canwire.web.trace.store.history import History
from canwire.web.trace.taps import Taps, Watched
from tests.hubs import served_here, until

LINE = "HW000001:0"


def told(taps: Taps, enough: Callable[[Watched], bool]) -> Watched:
    """What is said of the line, as soon as that is enough."""
    until(lambda: enough(taps.watched([LINE])[0]))
    return taps.watched([LINE])[0]


def test_a_line_that_nobody_watches_any_more_is_not_open_but_keeps_its_bus(tmp_path: Path) -> None:
    """Else the next viewer takes it for recorded, and misses what comes before it is."""
    with (
        served_here(tmp_path) as address,
        closing(HubLink(lambda: canwire.connect(address))) as link,
        closing(Taps(link, History(), linger_s=0)) as taps,
    ):
        assert not taps.watched([LINE])[0].open
        taps.want("a viewer", [LINE])
        assert told(taps, lambda one: one.open) == Watched(0, LINE, "can0", 0, "", True)
        assert taps.listening([LINE])
        taps.want("a viewer", [])
        assert told(taps, lambda one: not one.open) == Watched(0, LINE, "can0", 0, "", False)
        assert not taps.listening([LINE])


def test_a_line_whose_board_is_pulled_is_not_open(tmp_path: Path) -> None:
    with (
        served_here(tmp_path) as address,
        canwire.connect(address) as hub,
        closing(HubLink(lambda: canwire.connect(address))) as link,
        closing(Taps(link, History())) as taps,
    ):
        taps.want("a viewer", [LINE])
        told(taps, lambda one: one.open)
        hub.unplug("HW000001")
        told(taps, lambda one: not one.open and bool(one.trouble))


def test_a_line_that_a_viewer_leaves_while_it_is_opened_is_recorded_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As any other, for a page that comes back: else that page would show a gap before its first row."""

    def left_meanwhile(hub: canwire.Hub) -> list[LinePlace]:
        taps.want("a viewer", [])
        return list(every_line(hub))

    history = History()
    monkeypatch.setattr(taps_module, "every_line", left_meanwhile)
    with (
        served_here(tmp_path) as address,
        closing(HubLink(lambda: canwire.connect(address))) as link,
        closing(Taps(link, history)) as taps,
    ):
        taps.want("a viewer", [LINE])
        told(taps, lambda one: one.open)
        taps.want("another viewer", ["HW000002:0"])
        until(lambda: taps.listening(["HW000002:0"]))
        assert taps.listening([LINE])
    assert history.total == 0
