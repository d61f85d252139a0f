"""Windows with their threads: they work by themselves, and end with whatever they depend on."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

import canwire
from canwire import Frame
from canwire.web.cancheck.checking import Checking
from canwire.web.cancheck.receive import ReceiveWindow
from canwire.web.cancheck.send import SendWindow
from tests.candrv.bench import Peer
from tests.candrv.conftest import CONFIG
from tests.hubs import LONG_S, connected, embedded
from tests.web.cancheck.test_send import recipe

pytestmark = pytest.mark.conforms("FT-06")


class Running(Checking):
    """Whose changes can be waited for."""

    def __init__(self) -> None:
        super().__init__()
        self._changed = threading.Condition()
        self.listen(self._notify)

    def _notify(self) -> None:
        with self._changed:
            self._changed.notify_all()

    def until(self, ready: Callable[[], object]) -> None:
        with self._changed:
            assert self._changed.wait_for(ready, LONG_S)


@pytest.fixture
def hubs() -> Iterator[Callable[[str], canwire.Hub]]:
    with embedded(CONFIG, time="fast") as engine:
        yield lambda name: connected(engine, name)


@pytest.fixture
def running(hubs: Callable[[str], canwire.Hub]) -> Iterator[Running]:
    made = Running()
    made.start(hubs("page"), "CID1:")
    yield made
    made.leave()
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("CanCheck")]


@pytest.fixture
def peer(hubs: Callable[[str], canwire.Hub]) -> Iterator[Peer]:
    with closing(Peer(hubs("the rest"))) as made:
        yield made


def test_a_pair_sends_and_receives_by_itself(running: Running, peer: Peer) -> None:
    send, receive = running.open(receive=True, send=True)
    assert isinstance(send, SendWindow)
    assert isinstance(receive, ReceiveWindow)
    receive.set_filter(0, 0xFFFFFFFF)
    send.generators.add(recipe(0x123, delay_ms=1), active=True)
    peer.send(Frame(0x321))
    running.until(lambda: len(send.list.rows()) >= 5)
    running.until(lambda: any(row[4] == "00000321" for row in receive.list.rows()))
    running.until(lambda: sum(row[0] == "TRANSMITTED" for row in receive.list.rows()) >= 5)


def test_closing_ends_the_threads_of_that_window_alone(running: Running, peer: Peer) -> None:
    first, second = (running.open(receive=False, send=True)[0] for _ in range(2))
    assert isinstance(second, SendWindow)
    running.close(first.number)
    second.generators.add(recipe(0x123), active=True)
    running.until(lambda: second.list.rows())
    assert running.program.windows == [second]


def test_a_log_of_a_window_that_is_closed_is_complete(running: Running, peer: Peer, tmp_path: Path) -> None:
    (window,) = running.open(receive=False, send=True)
    assert isinstance(window, SendWindow)
    window.list.open_log(tmp_path / "sent.txt")
    window.generators.add(recipe(0x123, delay_ms=1), active=True)
    running.until(lambda: len(window.list.rows()) >= 10)
    running.close(window.number)
    assert len((tmp_path / "sent.txt").read_text().splitlines()) >= 10
