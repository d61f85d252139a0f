"""Waiting with select while another thread closes what is waited for."""

from __future__ import annotations

import errno
import selectors
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from typing import Any

import pytest

from canwire.platform.portable.polling import Poller

pytestmark = pytest.mark.skipif(
    sys.platform == "win32" or hasattr(selectors, "KqueueSelector"),
    reason="Linux' select is told what to see",
)


@pytest.fixture
def ends() -> Iterator[tuple[socket.socket, socket.socket]]:
    one, other = socket.socketpair()
    with one, other:
        yield one, other


def first(monkeypatch: pytest.MonkeyPatch, what: Callable[[], object]) -> None:
    """This happens in another thread after a wait has listed its descriptors, and before the system has seen them."""
    select = selectors.SelectSelector._select  # type: ignore[attr-defined]

    def late(readers: set[int], *rest: Any) -> Any:
        listed = list(readers)
        what()
        return select(listed, *rest)

    monkeypatch.setattr(selectors.SelectSelector, "_select", staticmethod(late))


@pytest.mark.conforms("N-19")
def test_one_that_is_unwatched_and_closed_as_a_wait_begins_ends_it(
    monkeypatch: pytest.MonkeyPatch, ends: tuple[socket.socket, socket.socket]
) -> None:
    one, other = ends
    with closing(Poller()) as poller:
        poller.watch(one.fileno(), Poller.READABLE)
        poller.watch(other.fileno(), Poller.READABLE)

        def gone() -> None:
            poller.unwatch(one.fileno())
            one.close()

        with monkeypatch.context() as patch:
            first(patch, gone)
            assert poller.wait(0) == []
        assert poller.wait(0) == [(other.fileno(), Poller.READABLE)]  # its other end is closed


def test_one_that_is_closed_and_still_watched_is_an_error(ends: tuple[socket.socket, socket.socket]) -> None:
    """Else whoever waits would turn for ever."""
    with closing(Poller()) as poller:
        poller.watch(ends[0].fileno(), Poller.READABLE)
        ends[0].close()
        with pytest.raises(OSError, match="Bad file descriptor") as raised:
            poller.wait(0)
        assert raised.value.errno == errno.EBADF
