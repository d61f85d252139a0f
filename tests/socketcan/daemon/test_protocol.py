"""The rest of doc/protocol.md: ISO-TP, buses that are set up, rubbish between commands; and Unix sockets."""

from __future__ import annotations

import socket
import stat
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from canwire import BadText, BadValue, Event, Hub, WantedMode, find_lines
from canwire.socketcan.daemon.daemon import Daemon
from canwire.socketcan.daemon.isotp import options_of, pdu_of
from canwire.socketcan.daemon.listening import Address, listener, parse_address
from tests.cases import each
from tests.gateway.test_gateway import CONFIG
from tests.hubs import LONG_S, connected, embedded

pytest.importorskip("numpy")
pytestmark = [pytest.mark.conforms("N-33"), pytest.mark.finding("machines 14")]
Connect = Callable[[], "Client"]


class Client:
    """The protocol, word by word."""

    def __init__(self, address: Address) -> None:
        unix = isinstance(address, str)
        self._socket = socket.socket(socket.AF_UNIX if unix else socket.AF_INET)
        self._socket.settimeout(LONG_S)
        self._socket.connect(
            f"\0{address[1:]}" if isinstance(address, str) and address[0] == "@" else address
        )
        self._read = self._socket.makefile("rb")
        assert self.heard() == "< hi >"

    def say(self, text: str) -> None:
        self._socket.sendall(text.encode())

    def heard(self) -> str:
        text = b""
        while not text.endswith(b">") and (byte := self._read.read(1)):
            text += byte
        return text.decode()

    def ask(self, text: str) -> str:
        self.say(text)
        return self.heard()

    def close(self) -> None:
        self._read.close()
        self._socket.close()


@pytest.fixture
def hub() -> Iterator[Hub]:
    with embedded(CONFIG) as engine, connected(engine) as made:
        yield made


@pytest.fixture
def connect(hub: Hub, request: pytest.FixtureRequest) -> Iterator[Connect]:
    """Clients of a daemon, at the address that the test asks for."""
    address: Address = getattr(request, "param", ("127.0.0.1", 0))
    daemon = Daemon(hub, address, WantedMode(), 0, lambda _: None)
    with ExitStack() as stack:
        stop = stack.enter_context(closing(Event(manual_reset=True)))
        thread = threading.Thread(target=daemon.run, args=(stop,))
        thread.start()
        stack.callback(thread.join, LONG_S)
        stack.callback(stop.set)
        yield lambda: stack.enter_context(closing(Client(daemon.address)))


def opened(connect: Connect, *words: str) -> Client:
    made = connect()
    for text in ("< open can0 >", *words):
        assert made.ask(text) == "< ok >"
    return made


def test_messages_over_iso_tp(connect: Connect) -> None:
    """Two channels, ends of each other: many frames with paddings and separation, and short ones."""
    one, other = opened(connect, "< isotpmode >"), opened(connect, "< isotpmode >")
    assert one.ask("< sendpdu 11 >") == "< error set the channel up first, as in: isotpconf 123 321 0 0 0 >"
    one.say("< isotpconf 1F998877 1F998876 C 4 0 0 AA 55 >")
    other.say("< isotpconf 1F998876 1F998877 C 8 1 0 55 AA >")
    assert other.ask("< echo >") == "< echo >"
    message = bytes(range(256)) * 2
    one.say(f"< sendpdu {message.hex()} >< sendpdu 0123 >")
    for wanted in (message, b"\x01\x23"):
        begin, word, time, pdu, end = other.heard().split(" ")
        assert (begin, word, bytes.fromhex(pdu), end) == ("<", "pdu", wanted, ">")
        assert float(time) >= 0
    other.say("< sendpdu 99 >")
    assert one.heard().endswith(" 99 >")
    assert one.ask("< rawmode >") == "< ok >"
    other.say("< sendpdu 55 >")
    assert " 0155555555555555 >" in one.heard()


def test_nobody_answers_a_long_message(connect: Connect) -> None:
    one = opened(connect, "< isotpmode >")
    opened(connect)  # who acknowledges
    one.say("< isotpconf 123 321 0 0 0 >")
    assert one.ask(f"< sendpdu {'00' * 20} >") == "< error pdu ECOMM >"


@each(
    ("words", "said"),
    [
        ("isotpconf 123 321 0 0", "and up to five more"),
        ("isotpconf 123 123 0 0 0", "two identifiers"),
        ("isotpconf 123 321 4 0 0 0", "too few words for flag 0x4"),
        ("isotpconf 123 321 4 0 0 0 100", "0 to 255"),
        ("isotpconf 1234 321 0 0 0", "11 bits"),
    ],
)
def test_channels_that_cannot_be(words: str, said: str) -> None:
    with pytest.raises(BadText, match=said):
        options_of(words.split())


def test_channels_and_messages_as_text() -> None:
    sends, receives, options = options_of(
        ["isotpconf", "00000123", "321", "202", "15", "F1", "9", "1", "2", "a", "b"]
    )
    assert (sends, receives) == (0x8000_0123, 0x321)
    assert (options.flags, options.block_size, options.stmin, options.most_waits) == (0x202, 15, 0xF1, 9)
    assert (options.tx_pad, options.rx_pad, options.address, options.address_heard) == (1, 2, 10, 11)
    assert pdu_of(["sendpdu", "00fF"]) == b"\x00\xff"
    for wrong in (["sendpdu"], ["sendpdu", "123"], ["sendpdu", "0g"]):
        with pytest.raises(BadText, match="two hex digits each"):
            pdu_of(wrong)


def test_a_bus_is_set_up_before_it_is_opened(hub: Hub, connect: Connect) -> None:
    one = connect()
    assert one.ask("< can0 B 250000 875 -1 -1 -1 -1 -1 -1 >< can0 C 1 0 0 >") == "< ok >"
    assert one.heard() == "< ok >"
    assert one.ask("< open can0 >") == "< ok >"
    running = [
        status.mode for place in find_lines(hub, "can0", "CAN") if (status := place.status(hub)).running
    ]
    assert {(mode.timing.bit_rate, mode.listen_only) for mode in running if mode and mode.timing} == {
        (250_000, True)
    }


@pytest.mark.parametrize(
    ("text", "answer"),
    [
        ("< can0 B 250000 >", "< error B: bitrate sample_point tq"),
        ("< can0 B x 1 2 3 4 5 6 7 >", "< error B: eight whole numbers >"),
        ("< can0 C 2 0 0 >", "< error C: listen_only loopback three_samples, each 0 or 1 >"),
        ("< can0 C 0 1 0 >", "< error configuring interface can0: "),
        ("< can9 B 1 1 1 1 1 1 1 1 >", "< error configuring interface can9: "),
        ("< can0 B 333333333 875 -1 -1 -1 -1 -1 -1 >", "< error configuring interface can0: "),
    ],
)
def test_what_cannot_be_set_up_is_told(connect: Connect, text: str, answer: str) -> None:
    assert connect().ask(text).startswith(answer)


def test_rubbish_before_a_command_is_skipped(connect: Connect) -> None:
    one = opened(connect)
    assert one.ask("GET / HTTP/1.1\r\n\r\n> x > y < echo > z") == "< echo >"
    assert one.ask("\x00\xff > < echo >") == "< echo >"


@pytest.mark.parametrize("connect", ["@canwire-test-socketcand"], indirect=True)
def test_an_abstract_unix_socket(connect: Connect) -> None:
    assert opened(connect).ask("< echo >") == "< echo >"


def test_a_unix_socket_is_its_users_alone_and_goes_with_the_server(hub: Hub, tmp_path: Path) -> None:
    path = tmp_path / "socketcand.sock"
    left = socket.socket(socket.AF_UNIX)
    left.bind(str(path))
    left.close()  # by a server that was killed
    daemon = Daemon(hub, parse_address(str(path)), WantedMode(), 0, lambda _: None)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    with pytest.raises(OSError, match="in use"):
        listener(str(path))
    daemon.close()
    assert not path.exists()
    with pytest.raises(BadValue, match="other machines cannot reach"):
        Daemon(hub, str(path), WantedMode(), 0, lambda _: None, beacon="192.168.0.255")
    path.write_text("no socket")
    with pytest.raises(OSError, match="in use"):
        listener(str(path))
    assert path.read_text() == "no socket"
