"""The end of a process ends the hubs in it, whose threads would otherwise run while the interpreter is taken apart."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from canwire.hub import in_process
from canwire.hub.links.local import LocalLink
from canwire.hub.owner.engine import VIRTUAL
from tests.cases import each


@each(
    "connect",
    [
        lambda: in_process._Common().connect("one"),
        lambda: in_process.fresh_link(VIRTUAL, None, "one"),
    ],
)
def test_the_end_of_the_process_ends_its_hubs(
    monkeypatch: pytest.MonkeyPatch, connect: Callable[[], LocalLink]
) -> None:
    monkeypatch.setattr(in_process, "_RUNNING", set())  # those of other tests go on
    link = connect()
    assert not link.lost
    in_process._end_all()
    assert link.lost
    link.close()
