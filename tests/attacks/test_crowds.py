"""Many at once: callers, boards, and slow requests; everybody is served."""

from __future__ import annotations

import socket
import struct
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import canwire
from canwire import ChannelMode, HubLost
from canwire.boards.config.configuration import Config
from canwire.hub.links.unix_socket import sockets
from canwire.hub.links.unix_socket.client import SocketLink
from canwire.hub.links.unix_socket.server import Server
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from tests.attacks.clients import Honest, hostile
from tests.hub.in_memory import Bench
from tests.hubs import serving


@pytest.mark.finding("faults 8")
def test_callers_queue_where_the_backlog_is_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody is turned away because many come at once."""
    monkeypatch.setattr(sockets, "_BACKLOG", 1)
    engine = Engine(World(Config.default()), "fast")
    server = Server(engine, str(tmp_path / "hub"))
    holding, going_on = threading.Event(), threading.Event()
    engine.post(lambda: (holding.set(), going_on.wait(30)))
    assert holding.wait(30)
    outcomes: list[object] = []

    def call() -> None:
        try:
            link = SocketLink(str(tmp_path / "hub"), "caller")
            outcomes.append(len(link.call(m.ListBoards())[0].boards))
            link.close()
        except BaseException as error:
            outcomes.append(error)

    threads = [threading.Thread(target=call) for _ in range(20)]
    for thread in threads:
        thread.start()
    going_on.set()
    for thread in threads:
        thread.join(30)
    server.close()
    engine.close()
    assert outcomes == [len(Config.default().board)] * 20


def test_a_hub_that_never_lets_in_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sockets, "_DIAL_TIMEOUT_S", 0)
    monkeypatch.setattr(sockets, "_TIME", Hasty)
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(tmp_path / "hub"))
        listener.listen(0)
        callers = []
        with pytest.raises(HubLost, match="a program listens but accepts no connection"):  # noqa: PT012
            for _ in range(10):
                callers.append(sockets.dial(str(tmp_path / "hub")))
        for caller in callers:
            caller.close()


class Hasty:
    """The shortest time there is, where none means for ever."""

    @staticmethod
    def pack(seconds: int, microseconds: int) -> bytes:
        return struct.pack("@ll", 0, 1)


@pytest.mark.finding("faults 8")
def test_a_thousand_boards_are_listed_page_by_page() -> None:
    bench = Bench(Config.parse("[[bus]]\nname = 'can0'\n"))
    hub = bench.hub()
    wanted = [hub.plug("usb-to-can").id for _ in range(700)]
    hub.unplug(hub.boards()[100].hardware_id)
    del wanted[100]
    assert [board.id for board in hub.boards()] == wanted
    page = hub.call(m.ListBoards())
    assert page.more
    assert len(m.encode_reply(1, page)) < m.LARGEST_REPLY // 4
    bench.close()


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    with serving(tmp_path) as (path, _):
        yield path


@pytest.mark.finding("faults 8")
def test_an_answer_that_is_too_long_ends_its_request_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    engine = Engine(World(Config.default()), "fast")
    server = Server(engine, str(tmp_path / "hub"))
    with canwire.connect(str(tmp_path / "hub")) as hub:
        hub.set_note("note", b"x" * 1000)
        with monkeypatch.context() as patch:
            patch.setattr(m, "LARGEST_REPLY", 500)
            with pytest.raises(canwire.HubError, match="the answer is too long"):
                hub.note("note")
        assert hub.note("note") == b"x" * 1000
    server.close()
    engine.close()


FILL = """
channel.close()
channels = [hub.open_channel(board, 1) for _ in range(4)]
for each in channels:
    each.set_up(canwire.ChannelMode(8, 8, filter_size=65_536))
def fill(each):
    while True:
        each.add_ids(0, 0x3FFF_FFFF & ~(0xFFFF << 1), extended=True)
for each in channels * 4:
    threading.Thread(target=fill, args=(each,), daemon=True).start()
"""


@pytest.mark.finding("faults 8")
def test_slow_requests_of_one_client_come_one_at_a_time(tmp_path: Path) -> None:
    """Of sixteen that wait, others wait for one."""
    engine = Engine(World(Config.default()), "fast")
    server = Server(engine, str(tmp_path / "hub"))
    order: list[str] = []
    with canwire.connect(str(tmp_path / "hub"), name="slow") as slow:
        other = SocketLink(str(tmp_path / "hub"), "other")
        slow_session, other_session = engine.call(lambda: list(engine.world.sessions))

        def take_time(request: m.Message, session: object) -> object:
            order.append("slow" if session is slow_session else "other")
            if session is slow_session:
                ends = time.monotonic() + 0.003
                while time.monotonic() < ends:
                    pass
            return m.Number(1), ()

        engine.call(lambda: [setattr(each, "_answer", take_time) for each in (slow_session, other_session)])
        held, holding = threading.Event(), threading.Event()
        engine.post(lambda: (held.set(), holding.wait(30)))
        assert held.wait(30)
        link = slow._link
        calls = [link.begin(m.CreateLuid()) for _ in range(16)]  # type: ignore[attr-defined]
        asked = other.begin(m.CreateLuid())
        holding.set()
        for call in (*calls, asked):
            call.result(30)
        other.close()
    server.close()
    engine.close()
    assert order.index("other") <= 2
    assert order.count("slow") == 16


def test_an_honest_client_beside_a_flood_of_filters(address: str) -> None:
    honest = Honest(address)
    with hostile(address, FILL):
        honest.exchange(50)
        assert honest.hub.boards()
    honest.exchange(10)
    honest.close()


def test_channels_by_the_thousand() -> None:
    bench = Bench()
    hub = bench.hub()
    for _ in range(2000):
        hub.open_channel(bench.board, 0)
    with pytest.raises(canwire.BadValue):
        hub.open_channel(bench.board, 0).set_up(ChannelMode(0, 0))
    bench.close()
