"""Callers that do not say who they are: let go when their time is over, while everybody else goes on."""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from canwire import HubError
from canwire.boards.config.configuration import Config
from canwire.hub.links.stream.server import StreamServer
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.platform import PORTABLE
from tests.hubs import LONG_S

if TYPE_CHECKING or not PORTABLE:
    from canwire.hub.links.unix_socket.client import SocketLink
    from canwire.hub.links.unix_socket.connection import SocketConnection
    from canwire.hub.links.unix_socket.server import Server
else:
    pytest.skip("the loopback address has a test of its own there", allow_module_level=True)


@contextlib.contextmanager
def server_at(path: str, kind: type[StreamServer], limit_s: float) -> Iterator[StreamServer]:
    engine = Engine(World(Config.default()), "fast")
    server = kind(engine, path)
    set_limit(server, limit_s)
    try:
        yield server
        assert engine.failures == 0
    finally:
        server.close()
        engine.close()


def set_limit(server: StreamServer, limit_s: float) -> None:
    """For callers that come from now on; until the next look at the silent ones an older limit would count."""
    server._greetings._limit_s = limit_s  # type: ignore[assignment]  # canwire.toml has whole seconds
    server._engine.call(server._greetings._look)


def said_until_the_end(caller: socket.socket) -> bytes:
    caller.settimeout(LONG_S)
    with contextlib.suppress(ConnectionResetError):  # it was hung up on before all it said was read
        return b"".join(iter(lambda: caller.recv(4096), b""))
    return b""


@pytest.mark.finding("faults-2 10")
@pytest.mark.parametrize("words", [b"", m.encode_request(1, m.Hello(m.VERSION, 1, "half"))[:-3]])
def test_a_greeting_has_a_time_limit(tmp_path: Path, words: bytes) -> None:
    path = str(tmp_path / "hub")
    with server_at(path, Server, LONG_S) as server, socket.socket(socket.AF_UNIX) as caller:
        link = SocketLink(path, "greets")
        set_limit(server, 0.05)
        caller.connect(path)
        caller.sendall(words)
        inbox = m.Inbox(m.LARGEST_REPLY)
        (payload,) = inbox.feed(said_until_the_end(caller))
        set_limit(server, LONG_S)  # a busy machine may greet late
        assert b"no greeting within 0.05 seconds" in payload
        assert b"greeting_seconds under [limits]" in payload
        later = SocketLink(path, "comes later")
        for each in (link, later):
            assert each.call(m.ListBoards())[0].boards
            each.close()
        assert server._engine.call(lambda: len(server._greetings._silent)) == 0


@pytest.mark.finding("faults-2 10")
def test_a_token_has_the_same_limit(tmp_path: Path) -> None:
    loopback = pytest.importorskip("canwire.hub.links.loopback.server")
    place = pytest.importorskip("canwire.hub.links.loopback.place")
    path = str(tmp_path / "hub")
    with server_at(path, loopback.LoopbackServer, 0.05) as server:
        with socket.create_connection(("127.0.0.1", place.read_place(path).port)) as caller:
            caller.sendall(b"half a token")
            assert said_until_the_end(caller) == b""
        assert server._engine.call(lambda: len(server._greetings._silent)) == 0


@pytest.mark.finding("faults-2 10")
def test_whoever_is_silent_makes_room_for_a_greeting(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Descriptors that run out while a caller's doorbell is made are taken from the oldest of the silent."""
    path = str(tmp_path / "hub")
    with server_at(path, Server, 60) as server:
        silent = [socket.socket(socket.AF_UNIX) for _ in range(5)]
        for caller in silent:
            caller.connect(path)
        server._engine.call(lambda: None)
        real = SocketConnection._new_doorbell
        full = OSError(24, "Too many open files")
        outcomes = iter([full, None, full, None, full])

        def scarce(self: SocketConnection) -> object:
            if (outcome := next(outcomes)) is not None:
                raise outcome
            return real(self)

        monkeypatch.setattr(SocketConnection, "_new_doorbell", scarce)
        for left in (1, 0):
            SocketLink(path, "greets").close()
            assert server._engine.call(lambda: len(server._greetings._silent)) == left
        with pytest.raises(HubError, match="descriptors"):
            SocketLink(path, "greets")
        for caller in silent:
            assert b"have not said who you are" in said_until_the_end(caller)
            caller.close()
