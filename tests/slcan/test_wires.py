"""Pseudo terminals, TCP connections and serial ports under a dongle."""

from __future__ import annotations

import os
import socket
import stat
import termios
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import serial

from canwire import BadValue, Event, Frame, InUse
from canwire.slcan import Dongle, PtyWire, SerialWire, Service, TcpWire, Wire
from tests.cases import each
from tests.hubs import until
from tests.slcan.bench import FakeCan

PATIENCE_S = 60.0


class Running:
    """Dongles in a service's thread. Frames reach them when `event` is set."""

    def __init__(self) -> None:
        self.stop = Event(manual_reset=True)
        self.service = Service()
        self.event = Event()
        self.can = FakeCan()
        self.dongle = Dongle(self.can, time.monotonic_ns)
        self._ended = False
        self._thread = threading.Thread(target=self.service.run, args=(self.stop,))

    def start(self, wire: Wire) -> None:
        self.service.add(self.dongle, self.event, wire)
        self._thread.start()

    def end(self) -> None:
        """A second time does nothing."""
        if self._ended:
            return
        self._ended = True
        self.stop.set()
        if self._thread.ident is not None:
            self._thread.join(PATIENCE_S)
        self.service.close()
        self.event.close()
        self.stop.close()


@pytest.fixture
def running() -> Iterator[Running]:
    running = Running()
    yield running
    running.end()


@pytest.mark.conforms("CT-21", "CT-14")
@pytest.mark.parametrize("baud_rate", [9600, 57_600, 3_000_000])
def test_any_baud_rate_will_do(running: Running, tmp_path: Path, baud_rate: int) -> None:
    running.start(PtyWire(tmp_path / "tty"))
    with serial.Serial(str(tmp_path / "tty"), baud_rate, timeout=PATIENCE_S) as port:
        port.write(b"\r\rV\rN\r")
        assert port.read(14) == b"\r\rV1013\rNA123\r"


def test_clients_come_and_go(running: Running, tmp_path: Path) -> None:
    link = str(tmp_path / "tty")
    running.start(PtyWire(link))
    for _ in range(5):
        with serial.Serial(link, timeout=PATIENCE_S) as port:
            port.write(b"V\r")
            assert port.read(6) == b"V1013\r"
    with open(link, "wb", buffering=0) as shell:  # as `printf 'S4\rO\r' > tty` does
        shell.write(b"S4\rO\r")
    until(lambda: running.can.opened)


def test_a_client_finds_the_terminal_raw_and_empty(running: Running, tmp_path: Path) -> None:
    link = str(tmp_path / "tty")
    wire = PtyWire(link)
    running.start(wire)
    rude = os.open(link, os.O_RDWR | os.O_NOCTTY)
    modes = termios.tcgetattr(rude)
    modes[3] |= termios.ECHO | termios.ICANON
    termios.tcsetattr(rude, termios.TCSANOW, modes)
    os.write(rude, b"V\rV\rV\r")
    until(lambda: running.dongle.counters.commands >= 3)
    os.close(rude)
    until(lambda: not termios.tcgetattr(wire.writing())[3] & (termios.ECHO | termios.ICANON))
    polite = os.open(link, os.O_RDWR | os.O_NOCTTY)
    try:
        assert not termios.tcgetattr(polite)[3] & (termios.ECHO | termios.ICANON)
        os.write(polite, b"N\r")
        read = b""
        while not read.endswith(b"NA123\r"):
            read += os.read(polite, 100)
        assert read == b"NA123\r"
    finally:
        os.close(polite)


def test_the_link_belongs_to_one(tmp_path: Path) -> None:
    link = tmp_path / "new" / "tty"
    wire = PtyWire(link)
    assert stat.S_ISCHR(link.stat().st_mode)
    with pytest.raises(InUse, match="another dongle"):
        PtyWire(link)
    wire.close()
    wire.close()
    assert not link.is_symlink()
    link.symlink_to(tmp_path / "nowhere")  # as somebody leaves it who was killed
    PtyWire(link).close()
    link.write_text("mine")
    with pytest.raises(BadValue, match="no symbolic link"):
        PtyWire(link)
    assert link.read_text() == "mine"


def test_a_client_that_never_reads_blocks_nothing(running: Running, tmp_path: Path) -> None:
    wire = PtyWire(tmp_path / "tty")
    running.start(wire)
    with serial.Serial(str(tmp_path / "tty"), write_timeout=PATIENCE_S) as port:
        port.write(b"S4\rO\r")
        until(lambda: running.can.opened)
        for _ in range(200):
            port.write(b"V\r" * 100)
            running.can.frames += [Frame(1, bytes(8))] * 100
            running.event.set()
        until(lambda: running.dongle.counters.commands >= 20_000)
    counters = running.dongle.counters
    assert counters.replies_lost > 0
    assert counters.lost > 0
    until(lambda: not wire.connected)
    with serial.Serial(str(tmp_path / "tty"), timeout=PATIENCE_S) as port:
        port.write(b"N\r")
        assert port.read(6) == b"NA123\r"


@pytest.mark.conforms("CT-21")
def test_tcp_serves_one_at_a_time(running: Running) -> None:
    wire = TcpWire("127.0.0.1:0")
    running.start(wire)
    assert wire.name == f"socket://127.0.0.1:{wire.port}"
    with serial.serial_for_url(wire.name, timeout=PATIENCE_S) as port:
        port.write(b"V\r")
        assert port.read(6) == b"V1013\r"
        with socket.create_connection(("127.0.0.1", wire.port), PATIENCE_S) as second:
            assert second.recv(1) == b""
        port.write(b"N\r")
        assert port.read(6) == b"NA123\r"
    until(lambda: not wire.connected)
    with socket.create_connection(("127.0.0.1", wire.port), PATIENCE_S) as again:
        again.sendall(b"V\r")
        assert again.recv(100) == b"V1013\r"
    assert wire.refused == 1


def ended(connection: socket.socket) -> bool:
    """Whether the other side has closed it; the system resets a connection with bytes that were not read yet."""
    try:
        return connection.recv(1) == b""
    except ConnectionResetError:
        return True


@pytest.mark.parametrize("said", [b"", b"V"], ids=["nothing", "half a line"])
def test_a_host_that_sends_no_command_keeps_nobody_out(running: Running, said: bytes) -> None:
    wire = TcpWire("127.0.0.1:0")
    running.start(wire)
    with socket.create_connection(("127.0.0.1", wire.port), PATIENCE_S) as silent:
        silent.sendall(said)
        until(lambda: wire.connected)
        with socket.create_connection(("127.0.0.1", wire.port), PATIENCE_S) as second:
            assert ended(silent)
            second.sendall(b"N\r")
            assert second.recv(100) == b"NA123\r"  # and not "VN": half a line went with who sent it
            with socket.create_connection(("127.0.0.1", wire.port), PATIENCE_S) as third:
                assert third.recv(1) == b""
    assert wire.refused == 1


def test_a_host_that_sends_no_command_is_let_go(running: Running) -> None:
    wire = TcpWire("127.0.0.1:0", greeting_s=0.01)
    running.start(wire)
    with socket.create_connection(("127.0.0.1", wire.port), PATIENCE_S) as silent:
        assert silent.recv(1) == b""
    until(lambda: not wire.connected)


def test_a_host_that_has_sent_a_command_may_be_silent(running: Running) -> None:
    wire = TcpWire("127.0.0.1:0", greeting_s=PATIENCE_S)
    running.start(wire)
    with socket.create_connection(("127.0.0.1", wire.port), PATIENCE_S) as host:
        until(lambda: wire.connected)
        assert wire.look_s is not None
        host.sendall(b"V\r")
        assert host.recv(100) == b"V1013\r"
        assert wire.look_s is None


@each("address", ["", "5000x", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1"])
def test_no_such_address(address: str) -> None:
    with pytest.raises(BadValue):
        TcpWire(address)


@pytest.mark.parametrize("address", ["0", ":0"])
def test_this_machine_only_unless_asked(address: str) -> None:
    wire = TcpWire(address)
    assert wire.name.startswith("socket://127.0.0.1:")
    wire.close()


@pytest.mark.conforms("CT-21")
def test_a_serial_port(running: Running) -> None:
    far, near = os.openpty()  # two ends of a cable: the host has the far one
    try:
        running.start(SerialWire(os.ttyname(near), 57_600))
        os.write(far, b"V\r")
        text = b""
        while len(text) < 6:
            text += os.read(far, 100)
        assert text == b"V1013\r"
    finally:
        os.close(near)
        running.end()
        os.close(far)
