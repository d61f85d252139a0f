"""Both links to a hub, in this process and over its socket, keep the same promises; and `connect` finds the hub."""

from __future__ import annotations

import contextlib
import gc
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from canwire import (
    BadConfig,
    BadValue,
    BitTiming,
    CanwireError,
    Hub,
    HubError,
    HubLost,
    NoSuchBoard,
    NothingHeard,
    connect,
    default_address,
    errors,
)
from canwire.boards.config.configuration import Config
from canwire.hub.links.answering import Server
from canwire.hub.links.calling import RemoteLink
from canwire.hub.links.local import LocalLink
from canwire.hub.owner.deferred import Deferred
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.failure import failed, raised
from canwire.hub.protocol.link import Link
from tests.cases import each
from tests.descriptors import open_descriptors
from tests.hub.links.ways import AGES, accept, leave_dead, listen, unix_only
from tests.hubs import until
from tests.missing import not_on_windows

SLOW = BitTiming.for_bit_rate(125_000, clock_hz=80_000_000)


class Place:
    """A hub, and any number of links to it of one kind."""

    def __init__(self, kind: str, path: Path, time: str = "fast") -> None:
        self.engine = Engine(World(Config.default(), virtual=time == "virtual"), time)
        self.server = Server(self.engine, str(path)) if kind == "socket" else None
        self.links: list[Link] = []

    def link(self, name: str = "test") -> Link:
        link = LocalLink(self.engine, name) if self.server is None else RemoteLink(self.server.path, name)
        self.links.append(link)
        return link

    def end(self) -> None:
        if self.server is not None:
            self.server.close()
        self.engine.close()

    def close(self) -> None:
        for link in self.links:
            link.close()
        self.end()


@pytest.fixture(params=["local", "socket"])
def place(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Place]:
    made = Place(request.param, tmp_path / "hub")
    yield made
    made.close()


def detect(link: Link, timeout_ms: int) -> Callable[[], Any]:
    """A request whose answer takes as long as the silent bus is listened to."""
    board = link.call(m.ListBoards())[0].boards[0]
    handle = link.call(m.OpenControl(board.id, 0))[0].handle
    return lambda: link.call(m.Detect(handle, ((SLOW, None),), timeout_ms, True, False))


class Caller(threading.Thread):
    """Makes one call and keeps what came of it."""

    def __init__(self, call: Callable[[], object]) -> None:
        super().__init__()
        self._call = call
        self.error: Exception | None = None
        self.start()

    def run(self) -> None:
        try:
            self._call()
        except Exception as error:
            self.error = error


# calls


def test_answers_and_errors(place: Place) -> None:
    link = place.link()
    assert link.time == "fast"
    reply, descriptors = link.call(m.ListBoards())
    assert [board.hardware_id for board in reply.boards] == ["HW000001", "HW000002", "HW000003", "HW000004"]
    assert descriptors == ()
    with pytest.raises(NoSuchBoard, match="4711"):
        link.call(m.OpenControl(4711, 0))
    assert not link.lost


def test_a_callers_mistake_costs_nothing(place: Place) -> None:
    link = place.link()
    for request in (m.Close("1"), m.Close(2**64), m.Unplug("x" * 100_000)):  # type: ignore[arg-type]
        with pytest.raises(BadValue, match=type(request).__name__):
            link.call(request)
    assert link.call(m.ListBoards())


@unix_only
def test_descriptors_are_the_clients_own(place: Place) -> None:
    import fcntl

    link = place.link()
    created, first = link.call(m.CreateFifo(10, 16))
    opened, second = link.call(m.OpenFifo(created.fifo, "reader"))
    assert len({*first, *second}) == 6
    for descriptor in (*first, *second):
        assert fcntl.fcntl(descriptor, fcntl.F_GETFD) & fcntl.FD_CLOEXEC
    link.call(m.Close(created.handle))
    link.call(m.Close(opened.handle))
    place.end()
    for descriptor in (*first, *second):
        assert os.fstat(descriptor)
        os.close(descriptor)


def test_many_threads_share_a_link(place: Place) -> None:
    link = place.link()
    numbers: list[int] = []

    def ask() -> None:
        for _ in range(50):
            numbers.append(link.call(m.CreateLuid())[0].value)

    threads = [Caller(ask) for _ in range(8)]
    for thread in threads:
        thread.join(AGES)
        assert thread.error is None
    assert len(set(numbers)) == 400


def test_an_answer_that_takes_time_holds_up_nobody_else(place: Place) -> None:
    link, other = place.link(), place.link()
    waiting = Caller(detect(link, 60_000))
    until(lambda: bool(place.engine.call(lambda: place.engine.world.sessions)))
    assert other.call(m.CreateLuid())
    assert link.call(m.CreateLuid())
    assert waiting.is_alive()


def test_a_late_error_is_raised_where_it_belongs(place: Place) -> None:
    with pytest.raises(NothingHeard):
        detect(place.link(), 20)()


def test_the_doorbell_tells_the_hub_who_rings(place: Place) -> None:
    place.link()
    link = place.link()
    kicked: list[object] = []
    place.engine.world.kick = kicked.append  # type: ignore[method-assign, assignment]
    link.doorbell.signal()
    until(lambda: bool(kicked))
    assert kicked == place.engine.world.sessions[1:]


# notices


def test_notices_reach_every_listener_whatever_one_does(
    place: Place, capfd: pytest.CaptureFixture[str]
) -> None:
    link, other = place.link(), place.link()
    heard: list[list[m.Message | None]] = [[], []]

    def fails(_: object) -> None:
        raise LookupError("a listener's mistake")

    link.listen(heard[0].append)
    link.listen(fails)
    link.listen(heard[1].append)
    link.call(m.Watch())
    plugged = other.call(m.Plug("usb-to-can", "", ()))[0].board
    until(lambda: all(len(notices) == 1 for notices in heard))
    handle = link.call(m.OpenChannel(plugged.id, 0, False))[0].handle
    other.call(m.Unplug(plugged.hardware_id))
    until(lambda: all(len(notices) == 3 for notices in heard))
    for changed, gone, again in heard:
        assert (changed, again) == (m.BoardsChanged(), m.BoardsChanged())
        assert isinstance(gone, m.Gone)
        assert gone.handles == (handle,)
    assert "LookupError: a listener's mistake" in capfd.readouterr().err


def test_a_listener_may_wait_for_a_lock_whose_holder_asks_the_hub(place: Place) -> None:
    link = place.link()
    lock, heard = threading.Lock(), threading.Event()

    def listener(_: object) -> None:
        with lock:
            heard.set()

    link.listen(listener)
    link.call(m.Watch())
    with lock:
        asking = Caller(lambda: (link.call(m.Plug("usb-to-can", "", ())), link.call(m.ListBoards())))
        asking.join(AGES)
        assert not asking.is_alive()
    assert heard.wait(AGES)


def test_a_listener_may_ask_the_hub(place: Place) -> None:
    link = place.link()
    found: list[Any] = []
    link.listen(lambda _: found.append(link.call(m.ListBoards())[0]))
    link.call(m.Watch())
    link.call(m.Plug("usb-to-can", "HW77", ()))
    until(lambda: bool(found))
    assert found[0].boards[-1].hardware_id == "HW77"


def test_after_close_not_even_what_waits_is_told(place: Place) -> None:
    link, other = place.link(), place.link()
    heard: list[m.Message | None] = []
    first, go_on = threading.Event(), threading.Event()

    def slow(notice: m.Message | None) -> None:
        heard.append(notice)
        first.set()
        go_on.wait(AGES)

    link.listen(slow)
    link.call(m.Watch())
    for _ in range(3):
        other.call(m.Plug("usb-to-can", "", ()))
    assert first.wait(AGES)
    link.call(m.ListBoards())  # its answer stands behind all three notices
    link.close()
    go_on.set()
    until(lambda: not [thread for thread in threading.enumerate() if thread.name == "canwire-notices"])
    assert heard == [m.BoardsChanged()]


# the end


def test_the_end_of_the_hub_wakes_everybody_up(place: Place) -> None:
    link = place.link()
    heard: list[m.Message | None] = []
    link.listen(heard.append)
    waiting = Caller(detect(link, 10**9)) if place.server is not None else Caller(detect(link, 10**6))
    until(lambda: len(place.engine.world.sessions) == 1 and waiting.is_alive())
    place.end()
    waiting.join(AGES)
    assert isinstance(waiting.error, HubLost)
    until(lambda: heard == [None])
    assert link.lost
    with pytest.raises(HubLost):
        link.call(m.ListBoards())
    link.listen(heard.append)
    assert heard == [None, None]


def test_closing_gives_everything_back_and_tells_nobody(place: Place) -> None:
    link, other = place.link("first"), place.link("second")
    board = link.call(m.ListBoards())[0].boards[0]
    heard: list[m.Message | None] = []
    link.listen(heard.append)
    link.call(m.OpenControl(board.id, 0))
    with pytest.raises(CanwireError, match="first"):
        other.call(m.OpenControl(board.id, 0))
    link.close()
    link.close()
    until(lambda: len(place.engine.world.sessions) == 1)
    assert other.call(m.OpenControl(board.id, 0))
    with pytest.raises(HubLost, match="closed"):
        link.call(m.ListBoards())
    assert heard == []


def test_closing_ends_waiting_calls(place: Place) -> None:
    link = place.link()
    waiting = Caller(detect(link, 10**6))
    until(lambda: any(s.held(object) for s in place.engine.call(lambda: list(place.engine.world.sessions))))
    link.close()
    waiting.join(AGES)
    assert isinstance(waiting.error, HubLost)


@not_on_windows("has no list of what is open")
def test_links_leave_nothing_behind(place: Place) -> None:
    def one() -> None:
        link = place.link()
        link.call(m.ListBoards())
        link.close()

    one()
    until(lambda: place.engine.call(lambda: len(place.engine.world.sessions)) == 0)
    before = open_descriptors()
    for _ in range(20):
        one()
    until(lambda: place.engine.call(lambda: len(place.engine.world.sessions)) == 0)
    assert open_descriptors() == before


# in this process


@pytest.fixture
def virtual(tmp_path: Path) -> Iterator[Place]:
    made = Place("local", tmp_path, "virtual")
    yield made
    made.close()


def test_in_virtual_time_waiting_lets_time_pass_and_no_more(virtual: Place) -> None:
    link = virtual.link()
    with pytest.raises(NothingHeard):
        detect(link, 1500)()
    assert 1_500_000_000 <= link.call(m.Advance(0))[0].value < 1_700_000_000


def test_in_virtual_time_nothing_happens_after_the_answer(virtual: Place) -> None:
    """Not even what is due at the very same time."""
    link = virtual.link()
    timeline = virtual.engine.world.timeline
    answer = Deferred()
    happened: list[str] = []
    timeline.at(1000, lambda: answer.settle((m.Number(7), ())))
    timeline.at(1000, lambda: happened.append("later"))
    virtual.engine.world.sessions[0].handle = lambda request: answer  # type: ignore[method-assign]
    assert link.call(m.CreateLuid()) == (m.Number(7), ())
    assert (timeline.now_ns, happened) == (1000, [])


def test_in_virtual_time_an_answer_that_cannot_come_says_so(virtual: Place) -> None:
    link = virtual.link()
    session = virtual.engine.world.sessions[0]
    session.handle = lambda request: Deferred()  # type: ignore[method-assign]
    with pytest.raises(HubError, match="CreateLuid would never end"):
        link.call(m.CreateLuid())


def test_a_kick_that_fails_ends_one_local_session(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    place = Place("local", tmp_path)
    link, other = place.link(), place.link()
    heard: list[m.Message | None] = []
    link.listen(heard.append)

    def broken(_: object) -> None:
        raise ArithmeticError("a bug")

    place.engine.world.kick = broken  # type: ignore[method-assign, assignment]
    link.doorbell.signal()
    until(lambda: heard == [None])
    assert link.lost
    with pytest.raises(HubLost):
        link.call(m.ListBoards())
    assert other.call(m.ListBoards())
    assert "ArithmeticError: a bug" in capfd.readouterr().err
    place.close()


# over a socket


def test_every_error_arrives_as_what_it_was() -> None:
    kinds = [
        kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, CanwireError)
    ]
    assert len(kinds) > 20
    for kind in kinds:
        sent: CanwireError = kind.__new__(kind, "line 1: what happened, and what to do")
        error = raised(failed(sent))
        assert type(error) is kind
        assert str(error) == "line 1: what happened, and what to do"


@each("name", ["NotKnownYet", "annotations", "object", "__name__", ""])
def test_other_names_are_plain_errors(name: str) -> None:
    error = raised(m.Failed(name, "text"))
    assert (type(error), str(error)) == (CanwireError, "text")


def test_nobody_there(tmp_path: Path) -> None:
    path = str(tmp_path / "nobody")
    with pytest.raises(HubLost, match="canwire serve --socket") as error:
        RemoteLink(path, "test")
    assert path in str(error.value)
    leave_dead(path)
    with pytest.raises(HubLost, match="canwire serve --socket"):
        RemoteLink(path, "test")


class Impostor:
    """Listens where a hub should be, and answers every Hello with the same bytes."""

    def __init__(self, path: Path, answer: bytes, then_close: bool = True) -> None:
        self.path = str(path)
        self._answer = answer
        self._then_close = then_close
        self._listener = listen(self.path)
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        caller = accept(self._listener, self.path)
        with caller, self._listener:
            caller.recv(1000)
            caller.sendall(self._answer)
            if not self._then_close:
                while caller.recv(1000):
                    pass

    def __enter__(self) -> Impostor:
        return self

    def __exit__(self, *_: object) -> None:
        self._thread.join(AGES)


def test_somebody_who_does_not_answer_is_no_hub(tmp_path: Path) -> None:
    with (
        Impostor(tmp_path / "s", b"", then_close=False) as silent,
        pytest.raises(HubLost, match="does not answer"),
    ):
        RemoteLink(silent.path, "test", hello_s=0.05)


@pytest.mark.parametrize(
    "answer",
    [
        b"",
        b"HTTP/1.1 400 Bad Request\r\n",
        m.encode_reply(1, m.Welcome(m.VERSION, "real"), 1),  # without the descriptor it counts
        m.LENGTH.pack(m.LARGEST_REPLY + 1),
    ],
)
def test_somebody_who_talks_rubbish_is_no_hub(
    tmp_path: Path, answer: bytes, capfd: pytest.CaptureFixture[str]
) -> None:
    with Impostor(tmp_path / "s", answer) as rubbish, pytest.raises(HubLost):
        RemoteLink(rubbish.path, "test")


def test_another_version_says_what_to_do(tmp_path: Path) -> None:
    words = m.Failed(
        "BadMessage", "the client speaks version 1, this hub 2; install the same canwire for both"
    )
    with (
        Impostor(tmp_path / "s", m.encode_reply(1, words)) as newer,
        pytest.raises(CanwireError, match="install the same canwire"),
    ):
        RemoteLink(newer.path, "test")


def test_the_hubs_last_words_are_passed_on(tmp_path: Path) -> None:
    words = m.encode_reply(0, m.Failed("HubError", "this hub belongs to user 12"))
    with Impostor(tmp_path / "s", words) as other, pytest.raises(HubLost, match="belongs to user 12"):
        RemoteLink(other.path, "test")


FORK = r"""
import os, signal, sys, time
from canwire import CanwireError, connect
hub = connect(sys.argv[1])
hub.open_control(hub.boards()[0].id, 0)
child = os.fork()
if child == 0:
    try:
        hub.boards()
    except CanwireError as error:
        told = "fork" in str(error) and hub.lost
    hub.close()
    os.write(1, f"child {told}\n".encode())
    time.sleep(30)
    os._exit(0)
while True:  # the parent's connection still works, whatever the child closed
    hub.boards()
    os.write(1, b"parent\n")
    time.sleep(30)
"""


@not_on_windows("has no fork")
def test_a_fork_cannot_use_its_parents_connection_nor_keep_it_alive(tmp_path: Path) -> None:
    place = Place("socket", tmp_path / "s")
    assert place.server is not None
    parent = subprocess.Popen(
        [sys.executable, "-W", "ignore", "-c", FORK, place.server.path],
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert parent.stdout is not None
    try:
        assert sorted(parent.stdout.readline() for _ in range(2)) == ["child True\n", "parent\n"]
        assert len(place.engine.world.sessions) == 1
        parent.kill()
        until(lambda: len(place.engine.world.sessions) == 0)  # though the child still runs
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(parent.pid, 9)  # the session of its own that was started above
        parent.wait()
        parent.stdout.close()
        place.close()


# connect


@pytest.fixture
def alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Nobody's hub or configuration around."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("CANWIRE_HUB", raising=False)
    monkeypatch.delenv("CANWIRE_CONFIG", raising=False)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_usual_address_is_the_users_own(alone: Path) -> None:
    assert default_address() == str(alone / "canwire.sock")


def test_without_a_hub_all_plain_calls_share_one_in_this_process(alone: Path) -> None:
    gc.collect()  # what an earlier test's traceback refers to may be a user of this process's hub
    before = threading.enumerate()  # hubs that other tests share
    with connect() as one, connect() as two:
        assert (one.address, one.time) == ("", "real")
        one.plug("usb-to-can", "HW77")
        assert two.board("HW77")
    with connect() as fresh, pytest.raises(NoSuchBoard):
        fresh.board("HW77")  # the first one went with its last user
    left = [thread for thread in threading.enumerate() if thread not in before]
    assert not [thread for thread in left if thread.name == "canwire-hub"]


LEAVE = """
import threading, time
from canwire import ChannelMode, connect
hub = connect()
channel = hub.open_channel(hub.boards()[0].id, 0)
channel.set_up(ChannelMode(16, 16))
channel.activate()
threading.Thread(target=channel.receive, args=(None,), daemon=True).start()
time.sleep(0.05)
"""


def test_a_program_may_end_without_closing_anything(alone: Path) -> None:
    source = str(Path(errors.__file__).parent.parent)
    done = subprocess.run(
        [sys.executable, "-c", LEAVE],
        capture_output=True,
        text=True,
        timeout=AGES,
        env={**os.environ, "PYTHONPATH": source},
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.parametrize("kind", ["real", "fast", "virtual"])
def test_a_time_of_its_own_means_a_hub_of_its_own(alone: Path, kind: str) -> None:
    with connect(time=kind) as one, connect(time=kind) as two:
        assert one.time == kind
        one.plug("usb-to-can", "HW77")
        with pytest.raises(NoSuchBoard):
            two.board("HW77")


def test_a_usual_hub_is_found(alone: Path) -> None:
    place = Place("socket", alone / "canwire.sock")
    with connect() as hub:
        assert hub.address == default_address()
    with connect(time="fast") as hub:
        assert hub.address == ""
    place.close()
    with connect() as hub:
        assert hub.address == ""


def test_a_given_address_counts_most_then_the_environment(
    alone: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    places = [Place("socket", alone / name) for name in ("canwire.sock", "environment", "given")]
    monkeypatch.setenv("CANWIRE_HUB", str(alone / "environment"))
    with connect() as hub:
        assert hub.address == str(alone / "environment")
    with connect(str(alone / "given")) as hub:
        assert hub.address == str(alone / "given")
    for place in places:
        place.close()
    with pytest.raises(HubLost):
        connect()


def test_an_address_has_its_own_time_and_boards(alone: Path) -> None:
    with pytest.raises(BadValue, match="time"):
        connect("somewhere", time="fast")
    with pytest.raises(BadValue, match="slow"):
        connect(time="slow")


def test_configurations(alone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def boards(hub: Hub) -> list[str]:
        with hub:
            return [board.hardware_id for board in hub.boards()]

    for serial in ("HWfile", "HWhere", "HWenv"):
        (alone / f"{serial}.toml").write_text(f'[[board]]\nkind = "usb-to-can"\nserial = "{serial}"\n')
    assert boards(connect()) == ["HW000001", "HW000002", "HW000003", "HW000004"]
    assert boards(connect(config=alone / "HWfile.toml")) == ["HWfile"]
    assert boards(connect(config=Config.load(str(alone / "HWfile.toml")))) == ["HWfile"]
    (alone / "HWhere.toml").rename(alone / "canwire.toml")
    assert boards(connect()) == ["HWhere"]
    assert boards(connect(time="virtual")) == ["HWhere"]
    monkeypatch.setenv("CANWIRE_CONFIG", str(alone / "HWenv.toml"))
    assert boards(connect()) == ["HWenv"]
    with pytest.raises(BadConfig, match=r"missing\.toml"):
        connect(config="missing.toml")


def test_the_name_is_shown_where_something_is_held(alone: Path) -> None:
    with connect(time="fast", name="my tester") as hub:
        board = hub.boards()[0]
        hub.open_control(board.id, 0)
        assert hub.line_status(board.id, 0).control_holder == f"my tester ({os.getpid()})"
