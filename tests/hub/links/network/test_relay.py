"""hub/links/network/relay: programs of one machine share a connection, and are to the hub what they are without it."""

from __future__ import annotations

import asyncio
import random
import socket
import threading
import zlib
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from itertools import chain
from typing import Any

import pytest

import canwire
from canwire import BadMessage, BadValue, Frame, HubError, HubLost
from canwire.hub.handles.hub import Hub
from canwire.hub.links.network.access import Access, Login, User
from canwire.hub.links.network.client import NetworkLink
from canwire.hub.links.network.offered import Offered
from canwire.hub.links.network.relay import at_hub, at_programs
from canwire.hub.links.network.relay.at_programs import RelayAtPrograms
from canwire.hub.links.network.relay.coding import CLOSE, DATA, OPEN, Decoder, Encoder, Said
from canwire.hub.links.network.relay.running import Running
from canwire.hub.links.network.session.settings import check_reach
from tests.hub.links.network.places import PATIENT, QUICK, Cable, Place, channel, elsewhere, offered, running
from tests.hubs import LONG_S, free_port, until

pytestmark = pytest.mark.conforms("PL-11")
SAID = [Said(OPEN, 1), Said(DATA, 1, bytes(range(256)) * 200), Said(DATA, 65_535, b"x"), Said(CLOSE, 1)]


def endpoint() -> str:
    return f"tcp/127.0.0.1:{free_port()}"


@contextmanager
def relayed(place: Place, port: int, said: list[str] | None = None) -> Iterator[str]:
    """The address for programs of a machine whose relay reaches the hub at this port."""
    warn = (lambda text: None) if said is None else said.append
    with closing(RelayAtPrograms(f"tcp/127.0.0.1:{port}", endpoint(), warn)) as relay:
        assert relay.address.startswith("zenoh://tests/bench?relay=tcp/127.0.0.1:"), place.address
        yield relay.address


@contextmanager
def bench(**changes: Any) -> Iterator[tuple[Place, int]]:
    """A hub that listens for relays, and at which port."""
    port = free_port()
    with offered(relay=(f"tcp/127.0.0.1:{port}",), **changes) as place:
        yield place, port


# the stream between two relays


@pytest.mark.parametrize("size", [1, 7, 1 << 20])
def test_messages_come_as_they_were_however_the_network_cuts_them(size: int) -> None:
    encoder, decoder = Encoder(), Decoder()
    stream = b"".join(map(encoder.encode, SAID))
    cut = (stream[at : at + size] for at in range(0, len(stream), size))
    assert list(chain.from_iterable(map(decoder.take, cut))) == SAID


def test_what_one_program_got_costs_next_to_nothing_for_the_next() -> None:
    encoder, batch = Encoder(), random.Random(1).randbytes(4_000)
    first, *others = [len(encoder.encode(Said(DATA, number, batch))) for number in range(5)]
    assert first > len(batch)
    assert max(others) < 100


@pytest.mark.parametrize("head", [b"\x00\x01\x00\x00\x00", b"\x05\x01\x00\x00\x00", b"\x01\x01\x00\x01\x00"])
def test_a_message_of_no_kind_is_refused(head: bytes) -> None:
    deflate = zlib.compressobj(wbits=-zlib.MAX_WBITS)
    stream = deflate.compress(head) + deflate.flush(zlib.Z_SYNC_FLUSH)
    with pytest.raises(BadMessage, match="a relay sent a message of kind"):
        list(Decoder().take(stream))


def test_what_is_not_compressed_or_ends_is_refused() -> None:
    with pytest.raises(BadMessage, match="not compressed"):
        list(Decoder().take(b"\xff" * 20))
    with pytest.raises(BadMessage, match="ended its compressed stream"):
        list(Decoder().take(zlib.compress(b"", wbits=-zlib.MAX_WBITS)))


# programs behind one


def test_each_program_has_its_own_queue_filter_and_count_of_losses() -> None:
    with bench() as (place, port), place.here() as here, relayed(place, port) as address:
        running(here)
        sends = channel(here, 0)
        with elsewhere(address, name="reads") as reads, elsewhere(address, name="sleeps") as sleeps:
            heard, full = channel(reads, 1), channel(sleeps, 1, receive=16)
            for number in range(100):
                sends.send(Frame(0x100, bytes((number,))), timeout=LONG_S)
            got: list[Frame] = []
            until(lambda: len(got) == 100 or bool(got.extend(heard.receive_many(100)) or len(got) == 100))
            assert [frame.data[0] for frame in got] == list(range(100))
            until(lambda: full.status().lost == 84)
            heard.send(Frame(0x200), timeout=LONG_S)
            back = sends.receive(LONG_S)
            assert back is not None
            assert back.id == 0x200


def test_a_relay_whose_connection_breaks_makes_another_one_and_nothing_is_lost() -> None:
    said: list[str] = []
    with bench(grace_s=LONG_S) as (place, port), place.here() as here, closing(Cable(port)) as cable:
        running(here)
        sends = channel(here, 0)
        with relayed(place, cable.port, said) as address, elsewhere(address, PATIENT) as reads:
            heard = channel(reads, 1)
            cable.hang_up()
            for number in range(10):
                sends.send(Frame(0x100, bytes((number,))), timeout=LONG_S)
            found = [heard.receive(LONG_S) for _ in range(10)]
            assert [frame and frame.data[0] for frame in found] == list(range(10))
            assert heard.status().lost == 0
    assert "broke: " in said[0]
    assert "again after" in said[1]


def test_a_task_that_loses_its_cancellation_is_cancelled_again() -> None:
    """As one in `asyncio.wait_for` of Python 3.11 may; the end of a relay waited for it without limit."""
    loop = Running("deaf")
    lost: list[bool] = []

    async def deaf() -> None:
        try:
            await asyncio.sleep(LONG_S)
        except asyncio.CancelledError:
            lost.append(True)
            await asyncio.sleep(LONG_S)

    async def begin() -> None:
        tasks.append(asyncio.ensure_future(deaf()))
        await asyncio.sleep(0)

    tasks: list[asyncio.Future[None]] = []
    loop.run(begin())
    loop.close()
    assert lost == [True]
    assert tasks[0].cancelled()


@pytest.mark.conforms("N-32")
def test_rights_hold_through_a_relay() -> None:
    users = {"eve": User(may="listen", password="ear")}
    with bench(access=Access(users=users)) as (place, port), relayed(place, port) as address:
        link = NetworkLink(address, "eve", Login(user="eve", password="ear"), QUICK)
        with Hub(link) as eve, pytest.raises(HubError, match="eve may only listen"):
            eve.plug("usb-to-can-fd", serial="HW9")
        with pytest.raises(HubLost):
            NetworkLink(address, "eve", Login(user="eve", password="eye"), QUICK)


def test_a_relay_that_carries_nobody_makes_room_for_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(at_hub, "RELAYS", 1)
    with (
        bench() as (place, port),
        relayed(place, port),
        relayed(place, port) as address,
        elsewhere(address) as program,
    ):
        assert program.boards()


def test_the_function_relays_until_it_is_stopped() -> None:
    ready, stop, said = threading.Event(), canwire.Event(manual_reset=True), list[str]()
    with bench() as (_, port), closing(stop):

        def told(address: str) -> None:
            said.append(address)
            ready.set()

        options: dict[str, Any] = {"listen": endpoint(), "ready": told, "stop": stop}
        thread = threading.Thread(target=canwire.relay, args=(f"tcp/127.0.0.1:{port}",), kwargs=options)
        thread.start()
        assert ready.wait(LONG_S)
        stop.set()
        thread.join(LONG_S)
        assert not thread.is_alive()


# what does not go


def test_where_no_relay_s_end_is_the_reason_is_told() -> None:
    with pytest.raises(HubLost, match="no relay's end answers; is `canwire offer --relay"):
        RelayAtPrograms(endpoint(), endpoint(), str)
    with socket.create_server(("127.0.0.1", 0)) as other:

        def answer() -> None:
            with other.accept()[0] as end:
                end.sendall(b"SSH-2.0\n")
                end.recv(1 << 10)

        thread = threading.Thread(target=answer)
        thread.start()
        with pytest.raises(HubError, match="no relay's end, or of another version"):
            RelayAtPrograms(f"tcp/127.0.0.1:{other.getsockname()[1]}", endpoint(), str)
        thread.join(LONG_S)


def ended(program: socket.socket) -> bool:
    """Whether the other side has closed this connection."""
    program.settimeout(LONG_S)
    with suppress(ConnectionResetError):
        while program.recv(1 << 10):
            pass
    return True


def test_a_connection_to_one_that_says_nothing_is_closed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(at_programs, "_CONNECT_S", 0.05)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        with pytest.raises(HubLost, match=r"no relay's end answers.*\(nothing was heard\)$"):
            RelayAtPrograms(f"tcp/127.0.0.1:{silent.getsockname()[1]}", endpoint(), str)
        with silent.accept()[0] as program:
            assert ended(program)


def test_connections_that_nobody_has_looked_at_yet_are_closed_in_the_end() -> None:
    loop, accepted, where = Running("accepts"), threading.Event(), free_port()
    loop.listen(f"tcp/127.0.0.1:{where}", lambda reader, writer: accepted.set())
    with socket.create_connection(("127.0.0.1", where)) as program:
        assert accepted.wait(LONG_S)
        loop.close()
        assert ended(program)


def test_a_taken_endpoint_is_named() -> None:
    with bench() as (_, port):
        taken = f"tcp/127.0.0.1:{port}"
        with pytest.raises(HubError, match=f"{taken}: cannot listen there"):
            RelayAtPrograms(taken, taken, str)


def test_relays_are_as_open_as_the_hub_and_need_one_that_does_not_encrypt() -> None:
    far = ("tcp/192.168.1.5:7450",)
    with pytest.raises(BadValue, match=r"192\.168\.1\.5:7450: other machines reach it"):
        check_reach(Offered().listen, None, insecure=False, relay=far)
    with pytest.raises(BadValue, match="what TLS has encrypted is never twice the same"):
        check_reach(("tls/127.0.0.1:7449",), None, insecure=True, relay=far)
