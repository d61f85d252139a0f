"""Who gets in at a hub on the loopback address, and what strangers who find its port can do: nothing.

What happens behind the door is the same as on a Unix socket: test_server.py and test_links.py, which
CANWIRE_PLATFORM=portable runs here.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import socket
import stat
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import HubError, HubLost
from canwire.boards.config.configuration import Config
from canwire.errors import BadMessage, LimitReached
from canwire.hub.links.loopback import asides, place, server, sockets
from canwire.hub.links.loopback.passing import Passing
from canwire.hub.links.loopback.place import Place, read_place
from canwire.hub.links.loopback.server import LoopbackServer
from canwire.hub.links.loopback.sockets import NONCE_SIZE, PROOF_SIZE, REST, dial, somebody_listens
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.platform.portable import events
from canwire.platform.portable.memory import Memory, create_memory
from canwire.platform.portable.pairs import LOOPBACK, loopback_listener
from tests.effort import examples
from tests.hubs import until
from tests.missing import not_on_windows

AGES = 60.0
TOKEN = bytes(range(32))
HELLO = m.encode_request(1, m.Hello(m.VERSION, os.getpid(), "wire"))


class Hub:
    """A hub on the loopback address, whatever platform this test runs on."""

    def __init__(self, path: Path) -> None:
        self.path = str(path)
        self.engine = Engine(World(Config.default()), "fast")
        self.server = LoopbackServer(self.engine, self.path)

    @property
    def place(self) -> Place:
        found = read_place(self.path)
        assert found is not None
        return found

    def sessions(self) -> int:
        return self.engine.call(lambda: len(self.engine.world.sessions))

    def strangers(self) -> int:
        return self.engine.call(lambda: len(self.server._strangers))

    def call(self) -> socket.socket:
        """Connected, and nothing said."""
        caller = socket.create_connection((LOOPBACK, self.place.port), AGES)
        caller.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return caller

    def close(self) -> None:
        self.server.close()
        self.engine.close()


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    tmp_path.chmod(0o700)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    return tmp_path


@pytest.fixture
def hub(home: Path) -> Iterator[Hub]:
    made = Hub(home / "hub")
    yield made
    made.close()
    assert made.engine.failures == 0


def ended(caller: socket.socket) -> bytes:
    """What came until the hub hung up."""
    said = b""
    with contextlib.suppress(ConnectionError):
        while data := caller.recv(1000):
            said += data
    caller.close()
    return said


# the place


@not_on_windows("has the rights of folders instead")
def test_port_and_token_are_for_the_user_alone(hub: Hub) -> None:
    assert stat.S_IMODE(os.lstat(hub.path).st_mode) == 0o600
    assert hub.server._listener.getsockname()[0] == "127.0.0.1"
    assert hub.place.token.hex() not in repr(hub.place)


def test_each_hub_has_a_token_of_its_own(home: Path) -> None:
    tokens = set()
    for _ in range(3):
        made = Hub(home / "hub")
        tokens.add(made.place.token)
        made.close()
    assert len(tokens) == 3
    assert not (home / "hub").exists()


@not_on_windows("has the rights of folders instead")
@pytest.mark.parametrize("mode", [0o640, 0o602, 0o666])
def test_a_place_that_others_can_open_is_refused(home: Path, mode: int) -> None:
    Place(1, TOKEN).write(str(home / "hub"))
    (home / "hub").chmod(mode)
    for use in (read_place, dial, somebody_listens):
        with pytest.raises(HubError, match="others may open it"):
            use(str(home / "hub"))


@not_on_windows("has the rights of folders instead")
def test_another_users_place_is_refused(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = home / "hub"
    Place(1, TOKEN).write(str(path))
    if os.geteuid() == 0:
        os.chown(path, 4711, -1)
    else:
        monkeypatch.setattr(os, "geteuid", lambda: path.stat().st_uid + 1)
    with pytest.raises(HubError, match="belongs to user"):
        dial(str(path))


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"canwire",
        b"canwire hub on loopback, version 1\nport 1\ntoken abc\n",
        b"canwire hub on loopback, version 2\nport 1\ntoken " + b"0" * 64 + b"\n",
        b"canwire hub on loopback, version 1\nport 999999\ntoken " + b"0" * 64 + b"\n",
        b"canwire hub on loopback, version 1\nport 1\ntoken " + b"0" * 64 + b"\n" + b"x" * 1_000_000,
        bytes(range(192, 256)),
    ],
)
def test_what_is_no_place_is_nobodys_and_stays(home: Path, text: bytes) -> None:
    path = home / "precious"
    path.write_bytes(text)
    path.chmod(0o600)
    assert read_place(str(path)) is None
    with pytest.raises(HubLost, match="no hub listens"):
        dial(str(path))
    with pytest.raises(HubError, match="no socket"):
        sockets.listen_at(str(path))
    assert path.read_bytes() == text


def test_a_port_beyond_all_ports_is_nobodys(home: Path) -> None:
    Place(99_999, TOKEN).write(str(home / "hub"))
    assert not somebody_listens(str(home / "hub"))
    with pytest.raises(HubLost, match="no hub listens"):
        dial(str(home / "hub"))


@not_on_windows("has the rights of folders instead")
def test_links_pipes_and_sockets_are_no_places(home: Path) -> None:
    Place(1, TOKEN).write(str(home / "real"))
    (home / "link").symlink_to(home / "real")
    os.mkfifo(home / "pipe")
    with socket.socket(socket.AF_UNIX) as left:
        left.bind(str(home / "socket"))
    assert [read_place(str(home / name)) for name in ("link", "pipe", "socket", "", "none")] == [None] * 5


def test_what_was_left_by_a_hub_that_was_killed_while_it_wrote_is_no_hindrance(home: Path) -> None:
    (home / "hub.new").write_text("half")
    Place(7, TOKEN).write(str(home / "hub"))
    assert [path.name for path in home.iterdir()] == ["hub"]


def test_a_start_that_another_one_holds_up_says_so(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(place, "_LOCK_PATIENCE_S", 0.0)
    with (
        place.changing_places(),
        pytest.raises(HubError, match="another hub of this user is starting"),
        place.changing_places(),
    ):
        pass


# callers


def test_who_knows_the_token_is_let_in_and_sees_that_the_hub_knows_it(hub: Hub) -> None:
    with dial(hub.path) as caller:
        caller.sendall(HELLO)
        inbox = m.Inbox(m.LARGEST_REPLY)
        payloads: list[bytes] = []
        while not payloads:
            payloads += inbox.feed(caller.recv(1000))
        assert m.decode_reply(payloads[0]) == (1, 0, m.Welcome(m.VERSION, "fast"))
        until(lambda: hub.strangers() == 0)
        assert hub.sessions() == 1


WRONG = {
    "zeros": bytes(32),
    "one bit": lambda token: bytes([token[0] ^ 1]) + token[1:],
    "the last bit": lambda token: token[:-1] + bytes([token[-1] ^ 0x80]),
    "as text": lambda token: token.hex().encode(),
    "late by one": lambda token: b"\0" + token,
    "HTTP": b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
    "Hello at once": HELLO * 2,
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_token_is_hung_up_on_at_once_and_nothing_said(hub: Hub, name: str) -> None:
    wrong: Any = WRONG[name]
    caller = hub.call()
    caller.sendall(wrong(hub.place.token) if callable(wrong) else wrong)
    assert ended(caller) == b""
    assert (hub.sessions(), hub.strangers()) == (0, 0)


@examples(60, same_fixtures=True)
@given(data=st.binary(max_size=200), right=st.integers(0, 31), cut=st.integers(0, 200))
def test_random_bytes_get_nowhere(hub: Hub, data: bytes, right: int, cut: int) -> None:
    """Behind any number of the token's first bytes, in any two pieces."""
    said = hub.place.token[:right] + data
    if said[:32] == hub.place.token:
        return
    caller = hub.call()
    with contextlib.suppress(OSError):  # it may hang up in the middle of it
        caller.sendall(said[:cut])
        caller.sendall(said[cut:])
        caller.shutdown(socket.SHUT_WR)
    assert ended(caller) == b""
    assert hub.sessions() == 0


def test_nothing_behind_a_wrong_token_is_read(hub: Hub, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    some = server.Caller._some

    def watched(self: server.Caller, most: int) -> bytes:
        asked.append(most)
        return some(self, most)

    monkeypatch.setattr(server.Caller, "_some", watched)
    caller = hub.call()
    caller.sendall(secrets.token_bytes(1000))
    assert ended(caller) == b""
    assert asked == [32]


def test_byte_by_byte_is_as_good(hub: Hub) -> None:
    caller, nonce = hub.call(), bytes(NONCE_SIZE)
    for byte in hub.place.token + REST.pack(nonce, 12):
        caller.sendall(bytes([byte]))
    proof = b""
    while len(proof) < PROOF_SIZE:
        proof += caller.recv(PROOF_SIZE)
    assert proof == hub.place.proof(nonce)
    caller.close()


def test_callers_that_say_nothing_make_room_for_others(hub: Hub) -> None:
    silent = [hub.call() for _ in range(200)]
    until(lambda: hub.strangers() == server._MOST_STRANGERS)
    dial(hub.path).close()
    hub.server.close()
    assert [ended(caller) for caller in silent] == [b""] * 200


def test_a_caller_that_gives_up_is_forgotten(hub: Hub) -> None:
    for said in (b"", hub.place.token[:7], hub.place.token, hub.place.token + b"half"):
        caller = hub.call()
        caller.sendall(said)
        caller.close()
    until(lambda: hub.strangers() == 0)
    assert hub.sessions() == 0


def test_its_first_requests_may_come_with_the_token(hub: Hub) -> None:
    caller = hub.call()
    caller.sendall(hub.place.token + REST.pack(bytes(NONCE_SIZE), 12) + HELLO)
    until(lambda: hub.sessions() == 1)
    caller.close()


def test_one_process_has_only_so_many_connections(home: Path) -> None:
    config = Config.parse("[limits]\nconnections = 3\n")
    engine = Engine(World(config), "fast")
    made = LoopbackServer(engine, str(home / "hub"))
    callers = [dial(str(home / "hub")) for _ in range(4)]
    assert b"3 of 3 connections" in ended(callers[3])
    for caller in callers[:3]:
        caller.close()
    made.close()
    engine.close()


# impostors: a dead hub's port may be anybody's


class Impostor:
    """Has the port of a hub that is dead, and says the same to everybody."""

    def __init__(self, path: Path, answer: bytes | None) -> None:
        self._listener = loopback_listener(8)
        self._answer = answer
        self._callers: list[socket.socket] = []
        Place(self._listener.getsockname()[1], TOKEN).write(str(path))
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                caller, _ = self._listener.accept()
                self._callers.append(caller)
                caller.recv(1000)
                if self._answer is not None:
                    caller.sendall(self._answer)
                    caller.close()

    def __enter__(self) -> Impostor:
        return self

    def __exit__(self, *_: object) -> None:
        with contextlib.suppress(OSError):  # Windows: no listener is connected
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self._thread.join(AGES)
        for caller in self._callers:
            caller.close()


@pytest.mark.parametrize("answer", [b"", bytes(PROOF_SIZE), b"220 mail ESMTP\r\n", TOKEN])
def test_who_cannot_show_that_it_knows_the_token_is_no_hub(home: Path, answer: bytes) -> None:
    with Impostor(home / "hub", answer):
        assert not somebody_listens(str(home / "hub"))
        with pytest.raises(HubLost, match="no hub listens"):
            dial(str(home / "hub"))


def test_the_port_of_a_dead_hub_that_a_stranger_has_now_is_no_hindrance(home: Path) -> None:
    with Impostor(home / "hub", b"go away"):
        made = Hub(home / "hub")
        dial(made.path).close()
        made.close()


def test_who_listens_and_says_nothing_may_be_a_hub_that_was_stopped(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sockets, "_DIAL_TIMEOUT_S", 0.05)
    with Impostor(home / "hub", None):
        assert somebody_listens(str(home / "hub"))
        with pytest.raises(HubLost, match="is the hub stopped"):
            dial(str(home / "hub"))
        with pytest.raises(HubError, match="another hub listens"):
            sockets.listen_at(str(home / "hub"))


# what is passed on


@pytest.fixture
def told() -> list[int]:
    return []


@not_on_windows("removes no file that is open")
def test_memory_is_kept_until_it_is_open_at_the_client(home: Path, told: list[int]) -> None:
    passing = Passing(told.append)
    sent = passing.hand_over((create_memory(64), *events.shared_event().copies()))
    [(kind, _, path), (other, number, _)] = asides.items_in(sent[m.LENGTH.size :])
    assert (kind, other, number, [str(p) for p in home.iterdir()]) == (asides.MEMORY, asides.EVENT, 1, [path])
    opened = Memory.open(path)
    passing.take(asides.FETCHED)
    assert list(home.iterdir()) == []
    with pytest.raises(BadMessage, match="memory that was not passed to it"):
        passing.take(asides.FETCHED)
    opened.close()


def test_memory_that_its_client_never_opened_goes_with_it(home: Path, told: list[int]) -> None:
    passing = Passing(told.append)
    passing.hand_over((create_memory(64),))
    passing.close()
    assert list(home.iterdir()) == []


def test_memory_that_nobody_opens_is_bounded(home: Path, told: list[int]) -> None:
    passing = Passing(told.append)
    for _ in range(256):
        passing.hand_over((create_memory(8),))
    with pytest.raises(LimitReached, match="256"):
        passing.hand_over((create_memory(8),))
    assert len(list(home.iterdir())) == 256
    passing.close()
    assert list(home.iterdir()) == []


def test_signals_find_their_client_and_its_own_find_the_others(told: list[int]) -> None:
    passing, shared = Passing(told.append), events.shared_event(both_ways=True)
    shared.signal()  # nobody has a copy yet
    mine = shared.copies()[0]
    early = shared.copies()
    shared.signal()  # before it is passed on
    assert asides.items_in(passing.hand_over(early)[m.LENGTH.size :]) == [(asides.BOTH_WAYS, 1, "")]
    assert told == [1]
    mine.clear()
    passing.take(asides.numbered(asides.SIGNALLED, 1)[m.LENGTH.size :])
    assert (mine.wait(0), told) == (True, [1])
    mine.signal()
    assert told == [1, 1]
    passing.take(asides.numbered(asides.DROPPED, 1)[m.LENGTH.size :])
    mine.signal()
    passing.take(asides.numbered(asides.SIGNALLED, 1)[m.LENGTH.size :])  # of one that is gone
    assert (mine.wait(0), told) == (True, [1, 1])


def test_nothing_is_kept_of_events_that_the_hub_closed_though_the_client_says_nothing(
    told: list[int],
) -> None:
    passing = Passing(told.append)
    for _ in range(3):
        shared = events.shared_event()
        passing.hand_over(shared.copies())
        shared.close()
    assert passing._events == {}


@given(data=st.binary(max_size=64), letter=st.sampled_from([b"S", b"D"]))
def test_asides_of_any_bytes_are_refused_or_nothing(data: bytes, letter: bytes) -> None:
    passing = Passing(lambda number: None)
    with contextlib.suppress(BadMessage):
        passing.take(letter + data)
        assert len(data) == 4
    with contextlib.suppress(BadMessage):
        for item in asides.items_in(b"P" + data):
            assert [type(part) for part in item] == [str, int, str]


@pytest.mark.parametrize("aside", [b"S", b"S123", b"D12345", b"F", b"Sxxxxx"])
def test_bad_asides_end_their_connection_alone(hub: Hub, aside: bytes) -> None:
    bystander, caller = dial(hub.path), dial(hub.path)
    for each in (bystander, caller):
        each.sendall(HELLO)
    until(lambda: hub.sessions() == 2)
    caller.sendall(m.LENGTH.pack(len(aside)) + aside)
    assert b"BadMessage" in ended(caller)
    until(lambda: hub.sessions() == 1)
    bystander.close()


def test_signals_of_events_that_never_were_are_nothing(hub: Hub) -> None:
    with dial(hub.path) as caller:
        caller.sendall(HELLO + asides.numbered(asides.SIGNALLED, 99) + asides.numbered(asides.DROPPED, 98))
        caller.sendall(
            asides.numbered(asides.SIGNALLED, asides.DOORBELL) * 1000 + m.encode_request(2, m.CreateLuid())
        )
        inbox, payloads = m.Inbox(m.LARGEST_REPLY), []
        while len(payloads) < 2:
            payloads += inbox.feed(caller.recv(1000))
        assert isinstance(m.decode_reply(payloads[1])[2], m.Number)
