"""socketcand's protocol on a hub's buses: python-can's own client, and the protocol word by word over a socket."""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from canwire import BadValue, Event, Frame, Hub, HubChannel, WantedMode
from canwire.commands import main
from canwire.socketcan.daemon.daemon import Daemon, announced, check_beacon
from canwire.socketcan.daemon.listening import parse_address
from canwire.socketcan.daemon.waiting import Selected
from canwire.socketcan.loop import Polled
from tests.gateway.test_gateway import CONFIG, got, program
from tests.hubs import LONG_S, connected, embedded, stopped_meanwhile

pytest.importorskip("numpy")


@pytest.fixture
def closing() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def hub(closing: ExitStack) -> Hub:
    return closing.enter_context(connected(closing.enter_context(embedded(CONFIG))))


@pytest.fixture
def said() -> list[str]:
    return []


@pytest.fixture(params=[Polled, Selected], ids=["epoll", "select"])
def daemon(
    hub: Hub,
    closing: ExitStack,
    said: list[str],
    request: pytest.FixtureRequest,
    monkeypatch: pytest.MonkeyPatch,
) -> Daemon:
    monkeypatch.setattr("canwire.socketcan.daemon.daemon.usual", request.param)
    made = Daemon(hub, ("127.0.0.1", 0), WantedMode(), 0, said.append, mappings={"vcan7": "can1"})
    stop = Event(manual_reset=True)
    thread = threading.Thread(target=made.run, args=(stop,))
    thread.start()

    def end() -> None:
        stop.set()
        thread.join(LONG_S)
        stop.close()

    closing.callback(end)
    return made


class Client:
    """The protocol, word by word."""

    def __init__(self, daemon: Daemon) -> None:
        self._socket = socket.create_connection(daemon.address, timeout=LONG_S)
        self._read = self._socket.makefile("rb")
        assert self.heard() == "< hi >"

    def say(self, text: str) -> None:
        self._socket.sendall(text.encode())

    def heard(self) -> str:
        text = b""
        while not text.endswith(b">"):
            byte = self._read.read(1)
            if not byte:
                return text.decode()
            text += byte
        return text.decode()

    def ask(self, text: str) -> str:
        self.say(text)
        return self.heard()

    def close(self) -> None:
        self._read.close()
        self._socket.close()


@pytest.fixture
def other(hub: Hub, closing: ExitStack) -> HubChannel:
    return program(hub, "can0", closing)


@pytest.fixture
def client(daemon: Daemon, other: HubChannel, closing: ExitStack) -> Client:
    made = Client(daemon)
    closing.callback(made.close)
    assert made.ask("< open can0 >") == "< ok >"
    return made


@pytest.mark.smoke
@pytest.mark.conforms("PL-08", "N-33")
@pytest.mark.filterwarnings("ignore")  # python-can's own
def test_python_can_s_client(daemon: Daemon, other: HubChannel) -> None:
    can = pytest.importorskip("can")
    with can.Bus(
        interface="socketcand", channel="can0", host=daemon.address[0], port=daemon.address[1]
    ) as bus:
        bus.send(can.Message(arbitration_id=0x123, data=[1, 2, 3], is_extended_id=False))
        assert got(other) == Frame(0x123, b"\x01\x02\x03")
        bus.send(can.Message(arbitration_id=0x18FEF100, data=bytes(8)))
        assert got(other) == Frame(0x18FEF100, bytes(8), extended=True)
        other.send(Frame(0x456, b"\xab\xcd"))
        heard = bus.recv(LONG_S)
        assert heard is not None
        assert (heard.arbitration_id, bytes(heard.data), heard.is_extended_id) == (0x456, b"\xab\xcd", False)
        other.send(Frame(0x7, b""))
        heard = bus.recv(LONG_S)
        assert heard is not None
        assert (heard.arbitration_id, heard.dlc) == (7, 0)


@pytest.mark.conforms("PL-08", "N-33")
def test_raw_mode(client: Client, other: HubChannel) -> None:
    assert client.ask("< rawmode >") == "< ok >"
    client.say("< send 1AAAAAAA 2 1 F1 >< sendrtr 123 2 >< fdsend 100 1 3 AA BB CC >")
    assert got(other) == Frame(0x1AAAAAAA, b"\x01\xf1", extended=True)
    assert got(other) == Frame(0x123, remote=True, dlc=2)
    assert got(other) == Frame(0x100, b"\xaa\xbb\xcc", fd=True, bit_rate_switch=True)
    for frame in (Frame(0x1, b"\x11"), Frame(2, remote=True, dlc=3), Frame(3, bytes(12), fd=True)):
        other.send(frame)
    words = [client.heard().split() for _ in range(3)]
    assert [(word[1], word[2]) for word in words] == [("frame", "001"), ("rtr", "002"), ("fdframe", "003")]
    assert [word[-2] for word in words] == ["11", "3", "00" * 12]
    assert client.ask("< echo >") == "< echo >"  # and nothing of its own came back


@pytest.mark.conforms("PL-08", "N-33")
def test_jobs_of_the_broadcast_manager(client: Client, other: HubChannel) -> None:
    client.say("< add 0 10000 123 2 11 22 >")
    assert [got(other).data for _ in range(3)] == [b"\x11\x22"] * 3
    assert client.ask("< update 123 1 33 >< echo >") == "< echo >"
    while got(other).data != b"\x33":
        pass
    assert client.ask("< delete 123 >< delete 123 >") == "< error there is no such job >"
    assert client.ask("< rawmode >< echo >") == "< ok >"


@pytest.mark.conforms("PL-08", "N-33")
def test_subscriptions_and_filters(client: Client, other: HubChannel) -> None:
    assert client.ask("< subscribe 0 0 123 >< filter 0 0 456 1 F0 >< echo >") == "< echo >"
    for frame in (
        Frame(0x123, b"\x01"),
        Frame(0x123, b"\x01"),
        Frame(0x789),
        Frame(0x456, b"\x10"),
        Frame(0x456, b"\x11"),
    ):
        other.send(frame)
    other.send(Frame(0x456, b"\x20"))
    heard = [client.heard().split() for _ in range(4)]
    assert [(words[2], words[4]) for words in heard] == [
        ("123", "01"),
        ("123", "01"),
        ("456", "10"),
        ("456", "20"),
    ]
    assert client.ask("< unsubscribe 123 >< echo >") == "< echo >"
    other.send(Frame(0x123))
    other.send(Frame(0x456, b"\x30"))
    assert client.heard().split()[2] == "456"


def test_statistics(client: Client, other: HubChannel) -> None:
    assert client.ask("< controlmode >") == "< ok >"
    other.send(Frame(1, bytes(5)))
    client.say("< statistics 1 >")
    while client.heard() != "< stat 5 1 0 0 >":
        pass
    client.say("< statistics 0 >< echo >")
    while client.heard() != "< echo >":
        pass


@pytest.mark.parametrize(
    ("text", "answer"),
    [
        ("< send 800 0 >", "< error identifier 800: 11 bits, or eight digits for 29 bits >"),
        ("<>", "< error empty command >"),
        ("nonsense\r\n< statistics >", "< error statistics: unknown command >"),
    ],
)
def test_mistakes_are_told_and_the_connection_goes_on(client: Client, text: str, answer: str) -> None:
    assert client.ask(text) == answer
    assert client.ask("< echo >") == "< echo >"


def test_buses_that_are_not_there(daemon: Daemon, closing: ExitStack) -> None:
    for text, answer in (
        ("< open can9 >", "< error could not open bus can9 >"),
        ("A" * 20_000, "< error command too long >"),
    ):
        stranger = Client(daemon)
        closing.callback(stranger.close)
        assert stranger.ask(text) == answer
        assert stranger.heard() == ""
    known = Client(daemon)
    closing.callback(known.close)
    assert known.ask("< rawmode >") == "< error open a bus first, as in: open can0 >"
    assert known.ask("< open vcan7 >") == "< ok >"


def test_more_than_the_bus_carries_is_read_more_slowly(client: Client, other: HubChannel) -> None:
    count = 3000
    sender = threading.Thread(
        target=client.say, args=("".join(f"< send 100 2 {n >> 8:x} {n & 255:x} >" for n in range(count)),)
    )
    sender.start()
    numbers = [int.from_bytes(got(other).data, "big") for _ in range(count)]
    sender.join(LONG_S)
    assert numbers == list(range(count))


def test_a_bus_that_goes_down_ends_its_clients(hub: Hub, client: Client) -> None:
    board = next(info for info in hub.boards() if hub.line_status(info.id, 0).running)
    assert client.ask("< rawmode >") == "< ok >"
    hub.unplug(board.hardware_id)
    text = client.heard()
    while text.startswith("< error 0"):  # error frames of the bus before that
        text = client.heard()
    assert "is down" in text
    assert client.heard() == ""


@pytest.fixture
def impatient(hub: Hub, closing: ExitStack, said: list[str]) -> Daemon:
    made = Daemon(hub, ("127.0.0.1", 0), WantedMode(), 0, said.append, greeting_s=0.5)
    stop = closing.enter_context(contextlib.closing(Event(manual_reset=True)))
    thread = threading.Thread(target=made.run, args=(stop,))
    thread.start()
    closing.callback(thread.join, LONG_S)
    closing.callback(stop.set)
    return made


@pytest.mark.parametrize("text", ["", "< open", "< echo >"], ids=["nothing", "half a line", "no bus"])
def test_a_client_that_opens_no_bus_is_closed(impatient: Daemon, text: str) -> None:
    client = Client(impatient)
    client.say(text)
    heard = [client.heard() for _ in range(3 if text.endswith(">") else 2)]
    assert heard[-2:] == ["< error no bus opened within 0.5 seconds >", ""]
    client.close()


def test_silent_clients_keep_nobody_out(daemon: Daemon, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("canwire.socketcan.daemon.daemon._MOST_CLIENTS", 2)
    oldest, other, third = (Client(daemon) for _ in range(3))
    assert oldest.heard() == "< error too many clients, and no bus opened here >"
    assert [other.ask("< open can0 >"), third.ask("< open can0 >")] == ["< ok >", "< ok >"]
    with socket.create_connection(daemon.address, timeout=LONG_S) as late:
        assert late.recv(1) == b""  # each of the others has a bus
    for client in (oldest, other, third):
        client.close()


def test_addresses() -> None:
    assert parse_address("") == ("127.0.0.1", 29536)
    assert parse_address("0.0.0.0") == ("0.0.0.0", 29536)
    assert parse_address("[::1]:7") == ("::1", 7)
    assert parse_address("7") == ("127.0.0.1", 7)
    for wrong in ("host:port", "1.2.3.4:99999"):
        with pytest.raises(BadValue):
            parse_address(wrong)


@pytest.mark.conforms("N-33")
def test_the_beacon(hub: Hub, said: list[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ear:
        ear.bind(("127.0.0.1", 0))
        ear.settimeout(LONG_S)
        monkeypatch.setattr("canwire.socketcan.daemon.daemon._BEACON_PORT", ear.getsockname()[1])
        made = Daemon(hub, ("127.0.0.1", 0), WantedMode(), 0, said.append, beacon="127.0.0.1")
        text = ear.recv(4096).decode()
        made.close()
    assert f"<URL>can://127.0.0.1:{made.address[1]}</URL>" in text
    assert '<Bus name="can0"/><Bus name="can1"/>' in text


@pytest.mark.finding("machines 14")
def test_a_beacon_names_an_address_that_others_reach() -> None:
    assert announced("0.0.0.0", "127.0.0.1") == "127.0.0.1"
    assert announced("192.168.1.5", "192.168.1.255") == "192.168.1.5"
    with pytest.raises(
        BadValue, match=r"beacon to 192\.168\.1\.255: it would name 127\.0\.0\.1, .* give --listen"
    ):
        check_beacon(("127.0.0.1", 1), "192.168.1.255")
    check_beacon(("0.0.0.0", 1), "192.168.1.255")


@pytest.mark.finding("machines 14")
@pytest.mark.parametrize(("words", "status"), [([], 2), (["--beside"], 0)])
def test_the_verb_says_that_its_hub_is_gone(
    hub: Hub,
    closing: ExitStack,
    words: list[str],
    status: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    engine = closing.enter_context(embedded(CONFIG))
    own = closing.enter_context(connected(engine))
    monkeypatch.setattr("canwire.commands.socketcan.socketcand.connected", lambda *_: own)
    monkeypatch.setattr(Daemon, "run", lambda self, stop: (self.close(), engine.close()))
    assert main(["socketcand", "--listen", "127.0.0.1:0", *words]) == status
    assert ("the hub is gone" in capsys.readouterr().err) == bool(status)


@pytest.mark.finding("socketcan 1")
def test_whoever_opens_a_bus_that_is_down_is_told(daemon: Daemon, hub: Hub, closing: ExitStack) -> None:
    first, second = Client(daemon), Client(daemon)
    closing.callback(first.close)
    closing.callback(second.close)
    with stopped_meanwhile(hub):
        assert first.ask("< open can1 >") == "< ok >"
        assert first.heard() == "< error can1 is down >"
    assert second.ask("< open can1 >") == "< ok >"
    assert second.heard() == "< error can1 is down >"
