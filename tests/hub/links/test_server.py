"""The server's socket: who gets in, what a client's bytes can do to the hub and to others, and what is left behind.

The clients here speak bytes, as a broken or hostile program would.
"""

from __future__ import annotations

import array
import contextlib
import gc
import os
import socket
import stat
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import CanwireError, HubError
from canwire.boards.config.configuration import Config
from canwire.hub.links.answering import Server
from canwire.hub.links.calling import somebody_listens
from canwire.hub.links.stream.outbox import Outbox
from canwire.hub.links.unix_socket import connection
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from tests.descriptors import open_descriptors
from tests.effort import examples
from tests.hub.links.ways import AGES, Stream, address_at, bare, leave_dead, sockets, unix_only
from tests.hubs import until

HELLO = m.encode_request(1, m.Hello(m.VERSION, os.getpid(), "wire"))


class Hub:
    """A server of the default world, and the engine behind it."""

    def __init__(self, path: Path) -> None:
        self.path = str(path)
        self.engine = Engine(World(Config.default()), "fast")
        self.server = Server(self.engine, self.path)

    def sessions(self) -> int:
        return self.engine.call(lambda: len(self.engine.world.sessions))

    def wait_for_sessions(self, count: int) -> None:
        until(lambda: self.sessions() == count)

    def close(self) -> None:
        self.server.close()
        self.engine.close()


class Wire(Stream):
    """A client that sends whatever bytes it likes."""

    def __init__(self, hub: Hub) -> None:
        super().__init__(hub.path)
        self._replies: list[tuple[int, Any]] = []

    def send(self, *data: bytes) -> Wire:
        with contextlib.suppress(OSError):  # the hub may hang up in the middle of it
            for piece in data:
                self.socket.sendall(piece)
        return self

    def ask(self, request: m.Message, serial: int = 9) -> Any:
        """The reply with this serial; notices and other replies are skipped."""
        self.send(m.encode_request(serial, request))
        while True:
            found, reply = self.reply()
            if found == serial:
                return reply

    def reply(self) -> tuple[int, Any]:
        """The next reply or notice; raises EOFError once the hub has hung up."""
        while not self._replies:
            for payload in self.receive():
                serial, count, reply = m.decode_reply(payload)
                assert count <= len(self.descriptors)
                self._replies.append((serial, reply))
        return self._replies.pop(0)

    def rest(self) -> list[tuple[int, Any]]:
        """All replies until the hub hangs up."""
        found = []
        with contextlib.suppress(EOFError):
            while True:
                found.append(self.reply())
        return found


@pytest.fixture
def hub(tmp_path: Path) -> Iterator[Hub]:
    made = Hub(tmp_path / "hub")
    yield made
    made.close()
    assert made.engine.failures == 0


@pytest.fixture
def wire(hub: Hub) -> Iterator[Wire]:
    made = Wire(hub)
    yield made
    made.close()


@pytest.fixture
def bystander(hub: Hub) -> Iterator[Wire]:
    """Another session, which nothing of what happens to the first one may touch."""
    made = Wire(hub)
    made.send(HELLO)
    assert made.reply()[0] == 1
    yield made
    assert isinstance(made.ask(m.ListBoards()), m.Boards)
    made.close()


# the socket


def test_only_its_user_can_reach_the_socket(hub: Hub) -> None:
    assert stat.S_IMODE(os.lstat(hub.path).st_mode) == 0o600


@unix_only
@pytest.mark.parametrize("stranger", [True, False])
def test_programs_of_this_user_and_of_root_are_let_in(
    hub: Hub, monkeypatch: pytest.MonkeyPatch, stranger: bool
) -> None:
    caller = os.getpid(), os.geteuid() + 1 if stranger else 0
    monkeypatch.setattr(connection, "peer_of", lambda _: caller)
    wire = Wire(hub)
    wire.send(HELLO)
    number, answer = wire.reply()
    if stranger:
        assert number == 0
        assert isinstance(answer, m.Failed)
        assert answer.text == f"this hub belongs to user {os.geteuid()}"
    else:
        assert number == 1
    wire.close()


def test_the_users_umask_makes_no_difference(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        hub = Hub(tmp_path / "s")
    finally:
        os.umask(before)
    assert stat.S_IMODE(os.lstat(hub.path).st_mode) == 0o600
    hub.close()


def test_a_clean_end_removes_the_socket(hub: Hub) -> None:
    hub.close()
    hub.close()
    assert not os.path.exists(hub.path)


def test_an_engine_that_ends_takes_its_server_along(hub: Hub, wire: Wire) -> None:
    wire.send(HELLO)
    wire.reply()
    hub.engine.close()
    assert wire.rest() == []
    assert not os.path.exists(hub.path)


def test_a_living_hubs_socket_is_left_alone(hub: Hub, bystander: Wire) -> None:
    engine = Engine(World(Config.default()), "fast")
    with pytest.raises(HubError, match="another hub listens"):
        Server(engine, hub.path)
    engine.close()


def test_a_dead_hubs_socket_is_replaced(tmp_path: Path) -> None:
    leave_dead(tmp_path / "s")
    hub = Hub(tmp_path / "s")
    wire = Wire(hub).send(HELLO)
    assert isinstance(wire.reply()[1], m.Welcome)
    wire.close()
    hub.close()


@unix_only
def test_its_path_appears_when_it_listens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A program that sees the file connects: it is never refused because the hub has only just begun."""
    seen: list[str] = []
    replace = os.replace

    def appears(source: str, target: str) -> None:
        assert not os.path.exists(target)
        assert somebody_listens(source)
        seen.append(target)
        replace(source, target)

    monkeypatch.setattr(os, "replace", appears)
    hub = Hub(tmp_path / "s")
    assert seen == [hub.path]
    assert os.listdir(tmp_path) == ["s"]
    hub.close()


def test_what_is_no_socket_is_never_removed(tmp_path: Path) -> None:
    file = tmp_path / "precious"
    file.write_text("data")
    engine = Engine(World(Config.default()), "fast")
    with pytest.raises(HubError, match="no socket"):
        Server(engine, str(file))
    engine.close()
    assert file.read_text() == "data"


def test_a_successors_socket_is_not_removed(hub: Hub) -> None:
    os.unlink(hub.path)
    successor = Hub(Path(hub.path))
    hub.close()
    wire = Wire(successor).send(HELLO)
    assert isinstance(wire.reply()[1], m.Welcome)
    wire.close()
    successor.close()


def test_of_many_hubs_that_start_at_once_one_wins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def slowly(path: str) -> bool:
        found = somebody_listens(path)
        time.sleep(0.01)  # long enough for everybody to find the dead hub's socket
        return found

    monkeypatch.setattr(sockets, "somebody_listens", slowly)
    leave_dead(tmp_path / "s")
    engine = Engine(World(Config.default()), "fast")
    won: list[Server] = []
    refused: list[HubError] = []
    together = threading.Barrier(6)

    def start() -> None:
        together.wait(AGES)
        try:
            won.append(Server(engine, str(tmp_path / "s")))
        except HubError as error:
            refused.append(error)

    threads = [threading.Thread(target=start) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(AGES)
    assert (len(won), len(refused)) == (1, 5)
    won[0].close()
    engine.close()


@unix_only
def test_too_long_a_path_says_so(tmp_path: Path) -> None:
    engine = Engine(World(Config.default()), "fast")
    with pytest.raises(CanwireError, match="too long"):
        Server(engine, str(tmp_path / ("x" * 120)))
    engine.close()


def test_virtual_time_is_not_for_servers(tmp_path: Path) -> None:
    engine = Engine(World(Config.default(), virtual=True), "virtual")
    with pytest.raises(CanwireError, match="virtual"):
        Server(engine, str(tmp_path / "s"))
    engine.close()


# greeting


def test_hello_is_welcomed_with_a_doorbell(hub: Hub, wire: Wire) -> None:
    serial, welcome = wire.send(HELLO).reply()
    assert (serial, welcome) == (1, m.Welcome(m.VERSION, "fast"))
    kicked: list[object] = []
    hub.engine.world.kick = kicked.append  # type: ignore[method-assign, assignment]
    wire.ring()
    until(lambda: hub.engine.call(lambda: list(kicked)) == hub.engine.world.sessions)


def test_another_version_is_refused(hub: Hub, wire: Wire, bystander: Wire) -> None:
    wire.send(m.encode_request(3, m.Hello(m.VERSION + 1, 1, "new")))
    [(serial, refusal)] = wire.rest()
    assert (serial, refusal.error) == (3, "BadMessage")
    assert "install the same canwire" in refusal.text
    hub.wait_for_sessions(1)


def test_names_cannot_play_tricks_on_terminals(hub: Hub, wire: Wire) -> None:
    wire.send(m.encode_request(1, m.Hello(m.VERSION, 1, "\x1b[31mred\n" + "x" * 1000)))
    wire.reply()
    name = hub.engine.call(lambda: hub.engine.world.sessions[0].name)
    assert name.isprintable()
    assert len(name) < 100
    assert str(os.getpid()) in name  # the kernel's word counts, not the client's


# rubbish: this session ends, nobody else notices

RUBBISH: dict[str, list[bytes | list[Any]]] = {
    "length 0": [HELLO, m.LENGTH.pack(0)],
    "oversized": [HELLO, m.LENGTH.pack(m.LARGEST_REQUEST + 1) + b"x" * 100],
    "4 GB": [m.LENGTH.pack(0xFFFFFFFF)],
    "no msgpack": [HELLO, m.LENGTH.pack(4) + b"\xc1\xc1\xc1\xc1"],
    "text": [b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"],
    "a request before Hello": [m.encode_request(5, m.ListBoards())],
    "a second Hello": [HELLO, m.encode_request(5, m.Hello(m.VERSION, 1, "again"))],
    "an unknown tag": [HELLO, [5, ["Explode", 1]]],
    "a reply": [HELLO, [5, ["Done"]]],
    "wrong types": [HELLO, [5, ["Close", "one"]]],
    "too few fields": [HELLO, [5, ["OpenControl", 1]]],
    "too many fields": [HELLO, [5, ["Close", 1, 1]]],
    "an impossible bit timing": [
        HELLO,
        [5, ["Detect", 1, [[{"prescaler": 0, "tseg1": 1, "tseg2": 1, "sjw": 1}, None]], 1, True, False]],
    ],
    "serial 0": [HELLO, [0, ["Watch"]]],
    "serial -1": [HELLO, [-1, ["Watch"]]],
    "no serial": [HELLO, ["Watch"]],
    "a nest": [HELLO, m.LENGTH.pack(60_002) + b"\x92\x05" + b"\x91" * 60_000],
}
SERIAL_KNOWN = {
    "a request before Hello",
    "a second Hello",
    "an unknown tag",
    "a reply",
    "wrong types",
    "too few fields",
    "too many fields",
    "an impossible bit timing",
}


def as_bytes(piece: bytes | list[Any]) -> bytes:
    if isinstance(piece, bytes):
        return piece
    payload = msgspec.msgpack.encode(piece)
    return m.LENGTH.pack(len(payload)) + payload


@pytest.mark.parametrize("what", RUBBISH)
@pytest.mark.parametrize("cut", [False, True], ids=["whole", "byte by byte"])
def test_rubbish_is_answered_and_the_session_ends(
    hub: Hub, wire: Wire, bystander: Wire, what: str, cut: bool
) -> None:
    stream = b"".join(map(as_bytes, RUBBISH[what]))
    if cut and len(stream) < 1000:
        wire.send(*(stream[k : k + 1] for k in range(len(stream))))
    else:
        wire.send(stream)
    replies = wire.rest()
    serial, refusal = replies[-1]
    assert isinstance(refusal, m.Failed)
    assert refusal.error == "BadMessage"
    assert serial == (5 if what in SERIAL_KNOWN else 0)
    hub.wait_for_sessions(1)


@examples(60, same_fixtures=True)
@given(data=st.binary(min_size=1, max_size=300), greeted=st.booleans())
def test_random_bytes_never_hurt_others(hub: Hub, bystander: Wire, data: bytes, greeted: bool) -> None:
    wire = Wire(hub)
    wire.send(HELLO if greeted else b"", data)
    wire.socket.shutdown(socket.SHUT_WR)
    assert len(wire.rest()) <= 3
    wire.close()
    assert isinstance(bystander.ask(m.CreateLuid()), m.Number)
    assert hub.engine.failures == 0


def test_a_truncated_request_and_a_hang_up(hub: Hub, wire: Wire, bystander: Wire) -> None:
    wire.send(HELLO, m.encode_request(2, m.ListBoards())[:-1])
    assert wire.reply()[0] == 1
    wire.socket.shutdown(socket.SHUT_WR)
    assert wire.rest() == []
    hub.wait_for_sessions(1)


@unix_only
def test_descriptors_from_a_client_are_dropped(hub: Hub, wire: Wire) -> None:
    """A hub takes none: they must not pile up in it."""
    wire.send(HELLO)
    wire.reply()
    before = open_descriptors()
    for serial in range(2, 12):
        request = m.encode_request(serial, m.Watch())
        rights = array.array("i", [wire.socket.fileno()] * 8)
        wire.socket.sendmsg([request], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, rights)])
        assert wire.reply() == (serial, m.Done())
    assert open_descriptors() == before


def test_errors_of_a_request_keep_the_session(hub: Hub, wire: Wire) -> None:
    wire.send(HELLO)
    wire.reply()
    refused = wire.ask(m.OpenControl(4711, 0))
    assert (refused.error, "4711" in refused.text) == ("NoSuchBoard", True)
    assert wire.ask(m.Close(12)).error == "NoSuchBoard"
    assert isinstance(wire.ask(m.ListBoards()), m.Boards)


def test_a_bug_in_the_hub_costs_one_session(
    hub: Hub, wire: Wire, bystander: Wire, capfd: pytest.CaptureFixture[str]
) -> None:
    wire.send(HELLO)
    wire.reply()

    def broken() -> int:
        raise ArithmeticError("a bug")

    hub.engine.world.next_luid = broken  # type: ignore[method-assign]
    wire.send(m.encode_request(5, m.CreateLuid()))
    [(serial, refusal)] = wire.rest()
    assert (serial, refusal.error) == (5, "HubError")
    hub.wait_for_sessions(1)
    assert capfd.readouterr().err.count("ArithmeticError: a bug") == 1
    assert hub.engine.failures == 1
    hub.engine.failures = 0


def test_a_doorbell_whose_kick_fails_costs_one_session(
    hub: Hub, wire: Wire, bystander: Wire, capfd: pytest.CaptureFixture[str]
) -> None:
    wire.send(HELLO)
    wire.reply()

    def broken(_: object) -> None:
        raise ArithmeticError("a bug")

    hub.engine.world.kick = broken  # type: ignore[method-assign, assignment]
    wire.ring()
    assert wire.rest() == []
    hub.wait_for_sessions(1)
    assert "ArithmeticError: a bug" in capfd.readouterr().err
    hub.engine.failures = 0


# floods


def test_a_client_that_does_not_read_is_hung_up(hub: Hub, wire: Wire, bystander: Wire) -> None:
    """Its replies take at most 4 MiB of the hub."""
    request = m.encode_request(2, m.ListBoards()) * 100
    wire.send(HELLO)
    with contextlib.suppress(ConnectionError):
        for _ in range(10_000):
            wire.socket.sendall(request)
    hub.wait_for_sessions(1)


def test_descriptors_that_nobody_takes_are_bounded(hub: Hub, wire: Wire, bystander: Wire) -> None:
    """Long before their replies take 4 MiB."""
    wire.send(HELLO)
    created = wire.ask(m.CreateFifo(1, 8))
    wire.send(m.encode_request(2, m.OpenFifo(created.fifo, "fifo")) * 2000)
    hub.wait_for_sessions(1)


class Reluctant:
    """A socket that takes a byte at a time, and now and then none."""

    def __init__(self) -> None:
        self.taken = b""
        self.came_with: dict[int, int] = {}
        self._turn = 0

    def send(self, data: memoryview) -> int:
        self._turn += 1
        if self._turn % 3 == 0:
            raise BlockingIOError
        self.taken += data[:1]
        return 1

    def sendmsg(self, data: list[memoryview], ancillary: list[tuple[int, int, Any]]) -> int:
        taken = self.send(data[0])
        [(_, _, descriptors)] = ancillary
        self.came_with[len(self.taken) - 1] = len(descriptors)
        return taken


@unix_only
def test_descriptors_go_with_the_first_byte_of_their_message_only() -> None:
    reluctant: Any = Reluctant()
    outbox = Outbox(reluctant)
    read, write = os.pipe()
    before = open_descriptors()
    for message, count in ((b"first", 1), (b"second", 0), (b"third", 2)):
        outbox.put(message, tuple(map(os.dup, (read, write)[:count])))
    while outbox:
        outbox.flush()
    assert reluctant.taken == b"firstsecondthird"
    assert reluctant.came_with == {0: 1, 11: 2}
    assert open_descriptors() == before
    outbox.put(b"never sent", (os.dup(read), os.dup(write)))
    outbox.close()
    assert open_descriptors() == before
    os.close(read)
    os.close(write)


def test_one_clients_flood_leaves_room_for_others(hub: Hub, wire: Wire, bystander: Wire) -> None:
    """Of thousands of requests that are there at once, others wait for a few only."""
    count = 3000
    wire.send(HELLO)
    wire.reply()
    flood = b"".join(m.encode_request(serial, m.CreateLuid()) for serial in range(2, 2 + count))
    hub.engine.post(lambda: time.sleep(0.1))  # so that everything below is there when it looks again
    wire.send(flood)
    between = bystander.ask(m.CreateLuid()).value
    numbers = [reply.value for _, reply in (wire.reply() for _ in range(count))]
    assert numbers[-1] - numbers[0] == count  # it had its number in between
    assert between < numbers[count // 2]


def test_replies_come_in_pieces_and_descriptors_once(hub: Hub, wire: Wire) -> None:
    """A reader that is slow to take megabytes still gets each byte, and each descriptor with its reply."""
    wire.send(HELLO)
    wire.reply()
    fifo = wire.ask(m.CreateFifo(1, 8))
    held = len(wire.descriptors)
    requests = [m.ListBoards()] * 1000
    for place in range(0, 1000, 100):
        requests.insert(place, m.OpenFifo(fifo.fifo, "fifo"))  # type: ignore[arg-type]
    for serial, request in enumerate(requests, 2):
        wire.send(m.encode_request(serial, request))
    hub.engine.call(lambda: None)
    replies = [wire.reply() for _ in requests]
    assert (
        sum(len(m.encode_reply(*reply)) for reply in replies) > 1_000_000
    )  # several times what a socket takes
    assert [serial for serial, _ in replies] == list(range(2, 2 + len(requests)))
    assert [isinstance(reply, m.FifoOpened) for _, reply in replies] == [
        isinstance(request, m.OpenFifo) for request in requests
    ]
    assert len(set(wire.descriptors)) == len(wire.descriptors) == held + 3 * 10


def test_callers_beyond_the_limit_of_descriptors_are_turned_away(hub: Hub, bystander: Wire) -> None:
    resource = pytest.importorskip("resource", reason="limits of descriptors are Linux'")
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    callers, address = [bare() for _ in range(20)], address_at(hub.path)
    gc.collect()
    used = max(map(int, os.listdir("/proc/self/fd"))) + 1
    plugs = []

    def turned_away(caller: socket.socket) -> bool:
        with contextlib.suppress(OSError):
            while True:
                plugs.append(os.dup(caller.fileno()))
        caller.connect(address)
        caller.settimeout(AGES)
        return caller.recv(1) == b""

    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (used + 4, hard))
        # one that is let in has a descriptor that a thread of an earlier test gave back meanwhile
        assert any(map(turned_away, callers))
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
        for plug in plugs:
            os.close(plug)
        for caller in callers:
            caller.close()


# ends


def test_what_a_client_held_is_free_the_moment_it_is_gone(hub: Hub, bystander: Wire) -> None:
    wire = Wire(hub).send(HELLO)
    wire.reply()
    board = wire.ask(m.ListBoards()).boards[0]
    assert isinstance(wire.ask(m.OpenControl(board.id, 0)), m.Opened)
    refused = bystander.ask(m.OpenControl(board.id, 0))
    assert refused.error == "InUse"
    wire.close()
    until(lambda: isinstance(bystander.ask(m.OpenControl(board.id, 0)), m.Opened))


def test_a_reset_connection_is_an_end_like_any_other(hub: Hub, bystander: Wire) -> None:
    wire = Wire(hub).send(HELLO, m.encode_request(2, m.ListBoards()))
    wire.close()  # with replies unread: the hub sees a reset
    hub.wait_for_sessions(1)


def test_nothing_is_left_of_sessions_that_ended(hub: Hub, bystander: Wire) -> None:
    def one(board: Any) -> None:
        wire = Wire(hub).send(HELLO)
        wire.reply()
        wire.ask(m.OpenChannel(board.id, 0, False))
        wire.ask(m.CreateFifo(10, 10))
        wire.close()

    board = bystander.ask(m.ListBoards()).boards[0]
    one(board)
    hub.wait_for_sessions(1)
    before = open_descriptors()
    for _ in range(200):
        one(board)
    hub.wait_for_sessions(1)
    assert open_descriptors() == before


def test_notices_reach_those_who_asked(hub: Hub, wire: Wire, bystander: Wire) -> None:
    wire.send(HELLO)
    wire.reply()
    assert wire.ask(m.Watch()) == m.Done()
    plugged = bystander.ask(m.Plug("usb-to-can", "", ()))
    assert wire.reply() == (0, m.BoardsChanged())
    bystander.ask(m.Unplug(plugged.board.hardware_id))
    assert wire.reply() == (0, m.BoardsChanged())
