"""CanCheck's model on a hub in virtual time, which stands still while nobody waits; its page on one in fast time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import canwire
from canwire.candrv.registry.registry import RegistryStore
from canwire.web.cancheck.program import CanCheck
from canwire.web.cancheck.receive import ReceiveWindow
from canwire.web.cancheck.send import SendWindow
from tests.candrv.bench import Bench, Peer
from tests.candrv.conftest import CONFIG, REGISTRY
from tests.hubs import embedded, served_here

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page

BOARD = "HW000501"  # a PicoCOM1: as on F&S's boards, three channels to send and two to receive


@pytest.fixture(autouse=True)
def registry(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> RegistryStore:
    """The registry of this test."""
    path = tmp_path_factory.mktemp("registry") / "canwire.toml"
    path.write_text(REGISTRY.format(BOARD))
    monkeypatch.setenv("CANWIRE_CONFIG", str(path))
    return RegistryStore(path)


@pytest.fixture
def bench(registry: RegistryStore) -> Iterator[Bench]:
    with embedded(CONFIG, time="virtual") as engine, Bench(engine) as made:
        yield made


class Program(CanCheck):
    """CanCheck on a bench: its time is the bench's."""

    def __init__(self, bench: Bench) -> None:
        super().__init__()
        self.bench = bench
        bench.peer.start()
        self.start(bench.hub, "CID1:")

    def receive(self, *, accept: bool = True) -> ReceiveWindow:
        (window,) = self.open(receive=True, send=False)
        assert isinstance(window, ReceiveWindow)
        if accept:
            window.set_filter(0, 0xFFFFFFFF)
        return window

    def send(self) -> SendWindow:
        (window,) = self.open(receive=False, send=True)
        assert isinstance(window, SendWindow)
        return window

    def pair(self) -> tuple[SendWindow, ReceiveWindow]:
        send, receive = self.open(receive=True, send=True)
        assert isinstance(send, SendWindow)
        assert isinstance(receive, ReceiveWindow)
        receive.set_filter(0, 0xFFFFFFFF)
        return send, receive

    def run(self, seconds: float) -> None:
        """Let so much time pass, with every generator firing when it is due."""
        end_ns = self.bench.hub.now_ns() + round(seconds * 1e9)
        windows = [one for one in self.windows if isinstance(one, SendWindow)]
        while True:
            waits = [wait for one in windows if (wait := one.generators.fire()) is not None]
            left_ns = end_ns - self.bench.hub.now_ns()
            if left_ns <= 0:
                break
            self.bench.run(min([left_ns, *waits]) / 1e9)
        for window in self.windows:
            window.take()


@pytest.fixture
def program(bench: Bench) -> Iterator[Program]:
    made = Program(bench)
    yield made
    made.leave()


# in the browser


@pytest.fixture
def hub_address(home: Path) -> Iterator[str]:
    """In fast time, with the boards of CANDRV's tests."""
    with served_here(home, CONFIG) as made:
        yield made


@pytest.fixture
def peer(hub: canwire.Hub) -> Iterator[Peer]:
    with closing(Peer(hub)) as made:
        yield made


@pytest.fixture
def view() -> str:
    return "cancheck"


@pytest.fixture
def cancheck(page: Page, peer: Peer) -> Page:
    """Started on CID1:, in a tab."""
    return started(page)


def started(page: Page) -> Page:
    """CanCheck on CID1:, in this tab."""
    page.get_by_role("button", name="Start", exact=True).click()
    page.get_by_role("heading", name="CanCheck", exact=True).wait_for()
    page.get_by_role("button", name="ENTER_STANDBY").wait_for()
    return page


def panel(page: Page, kind: str) -> Locator:
    """A window of that kind, once it is there."""
    found = page.locator(f".window[data-kind={kind}]").first
    found.wait_for()
    return found
