"""How a bus comes to its end: forgotten, under a Notifier, in a fork, with its hub or its interpreter."""

from __future__ import annotations

import os
import select
import socket
import subprocess
import sys
import threading

import can
import pytest

from canwire.platform import EventDescriptor
from canwire.python_can import CanwireBus, receiver
from canwire.python_can.ending import OpenBuses
from tests.hubs import Served
from tests.python_can.programs import Open, Program

LONG = 30


def message(id: int = 0x123, data: bytes = b"\1\2") -> can.Message:
    return can.Message(arbitration_id=id, data=data, is_extended_id=id > 0x7FF)


FORGETFUL = {
    "nothing": "",
    "sent": "for k in range(300): bus.send(can.Message(arbitration_id=k, is_extended_id=False))",
    "periodic": "task = bus.send_periodic(can.Message(arbitration_id=1, is_extended_id=False), 0.01)",
    "notifier": "notifier = can.Notifier(bus, [])",
    "fileno": "bus.fileno()",
    "interrupted": "raise KeyboardInterrupt",
}


@pytest.mark.finding("python-can 1")
@pytest.mark.parametrize("what", FORGETFUL)
def test_a_program_that_forgets_shutdown_ends(program: Program, open_bus: Open, what: str) -> None:
    other = open_bus()
    body = f"import can\nbus = can.Bus(interface='canwire', channel='can0')\n{FORGETFUL[what]}\n"
    process = program(body, ready=False, stderr=subprocess.PIPE, cold=what == "nothing")
    _, said = process.communicate("", LONG)
    assert "not properly shut down" in said
    assert (process.returncode == 0) == (what != "interrupted")
    if what == "sent":
        heard = [other.recv(LONG).arbitration_id for _ in range(300)]
        assert heard == list(range(300))


def test_a_thread_that_receives_at_the_end_gets_no_error(
    open_bus: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    """python-can's Notifier printed it in a daemon thread while the interpreter ended, which aborts: status -6."""
    bus = open_bus()
    ending = OpenBuses()
    ending.add(bus)
    monkeypatch.setattr(receiver, "OPEN_BUSES", ending)
    ending.end()
    assert bus.recv(0.001) is None


@pytest.mark.finding("python-can 1")
def test_the_interpreters_end_asks_the_hub_for_nothing(served: Served) -> None:
    """A holder whose own `__del__` closes it that late."""
    body = f"""
import canwire
class Late:
    def __init__(self):
        self.hub = canwire.connect({served.address!r})
    def __del__(self):
        try:
            self.hub.boards()
        except canwire.HubLost as error:
            print(error, flush=True)
        self.hub.close()
late = Late()
"""
    ended = subprocess.run([sys.executable, "-c", body], capture_output=True, text=True, timeout=LONG)
    assert ended.returncode == 0, ended.stderr
    assert "interpreter is ending" in ended.stdout


@pytest.mark.finding("python-can 2")
def test_a_closed_bus_touches_nobody_elses_descriptor(open_bus: Open) -> None:
    bus = open_bus()
    number = bus.fileno()
    bus.shutdown()
    taken: list[socket.socket] = []
    while not any(one.fileno() == number for one in taken):
        taken += socket.socketpair()
    at = [one.fileno() for one in taken].index(number)
    ours, theirs = taken[at], taken[at ^ 1]
    theirs.send(b"not for you")
    for _ in range(2):
        with pytest.raises(can.CanOperationError, match="Notifier"):
            bus.recv(0)
    with pytest.raises(can.CanOperationError, match="closed"):
        bus.fileno()
    assert ours.recv(100) == b"not for you"
    for one in taken:
        one.close()


@pytest.mark.finding("python-can 2")
def test_a_closed_event_forgets_its_descriptor() -> None:
    ours, theirs = socket.socketpair()
    event = EventDescriptor()
    number = event.fileno()
    event.close()
    os.dup2(ours.fileno(), number)
    theirs.send(b"mine")
    event.clear()
    event.signal()
    assert not event.wait(0)
    assert os.read(number, 100) == b"mine"
    assert not select.select([theirs], [], [], 0)[0]
    os.close(number)
    ours.close()
    theirs.close()


@pytest.mark.finding("python-can 2")
@pytest.mark.parametrize("watched", [False, True])
def test_who_receives_gets_none_at_shutdown(open_bus: Open, watched: bool) -> None:
    bus, got, waits = open_bus(), [], threading.Event()
    if watched:
        bus.fileno()

    def receive() -> None:
        waits.set()
        got.append(bus.recv(LONG))

    thread = threading.Thread(target=receive)
    thread.start()
    waits.wait(LONG)
    while not bus._receiver._end._waiting:
        pass
    bus.shutdown()
    thread.join(LONG)
    assert got == [None]


@pytest.mark.finding("python-can 2", "issue 15.7")
def test_a_notifier_outlives_its_bus(open_bus: Open) -> None:
    class Listener(can.Listener):
        def on_message_received(self, msg: can.Message) -> None:
            pass

        def on_error(self, exc: Exception) -> None:
            failures.append(exc)
            notifier._stopped = True

    failures: list[Exception] = []
    bus = open_bus()
    notifier = can.Notifier(bus, [Listener()], timeout=0.05)
    bus.shutdown()
    for reader in notifier._readers:
        reader.join(LONG)
    notifier.stop()
    assert [type(failure) for failure in failures] == [can.CanOperationError]
    assert "stop what still uses it" in str(failures[0])


@pytest.mark.finding("python-can 10.1")
@pytest.mark.parametrize("embedded", [False, True])
def test_a_forks_handles_say_so_and_leave_the_parents_messages(
    open_bus: Open, embedded: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: object
) -> None:
    if embedded:
        monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
        monkeypatch.delenv("CANWIRE_HUB", raising=False)
        a, b = CanwireBus(), CanwireBus()
    else:
        a, b = open_bus(), open_bus()
    for k in range(3):
        a.send(message(k))
    assert b.recv(LONG).arbitration_id == 0
    while a.channel_status().delivered < 3:
        pass
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        said = []
        for use in (lambda: b.recv(0), lambda: b.send(message()), b.fileno, lambda: b.state):
            try:
                use()
                said.append("nothing")
            except can.CanOperationError as error:
                said.append(str(error))
        os.write(writing, "\n".join(said).encode())
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0
    said = os.read(reading, 10_000).decode().splitlines()
    os.close(reading)
    os.close(writing)
    assert [line.count("belongs to the process that was forked") for line in said] == [1] * 4
    assert [b.recv(LONG).arbitration_id for _ in range(2)] == [1, 2]
    if embedded:
        a.shutdown()
        b.shutdown()


@pytest.mark.finding("issue 15.7")
def test_a_hub_that_goes_is_told_with_a_remedy(served: Served, open_bus: Open) -> None:
    bus = open_bus()
    served.process.kill()
    with pytest.raises(can.CanOperationError, match=r"hub is gone.*canwire serve"):
        bus.recv(LONG)
