"""Who is let in and may do what; and each of Zenoh's hazards with the setting that answers it."""

from __future__ import annotations

import json
import socket
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

import pytest

import canwire
from canwire import BadConfig, BadValue, ChannelMode, Frame, HubError, HubLost
from canwire.hub.handles.hub import Hub
from canwire.hub.links.network import access, discovery, keys
from canwire.hub.links.network.access import Access, Login, Router, Tls, User
from canwire.hub.links.network.client import NetworkLink
from canwire.hub.links.network.session import settings
from canwire.hub.links.network.session.settings import (
    LEASE_S,
    SESSIONS,
    Patience,
    check_reach,
    for_client,
    for_hub,
    for_router,
    load_zenoh,
    open_for_client,
    open_for_hub,
    open_session,
    usual,
)
from canwire.hub.protocol import messages as m
from tests.cases import each
from tests.hub.links.network.places import QUICK, Place, channel, elsewhere, offered, running
from tests.hubs import LONG_S, free_port, until

pytestmark = pytest.mark.conforms("PL-11")

USERS = {
    "alice": User(may="configure", password="secret"),
    "bob": User(may="send", password="pass"),
    "eve": User(may="listen", password="ear"),
}


def as_user(place: Place, user: str, password: str, patience: Patience | None = None) -> Hub:
    return Hub(NetworkLink(place.address, user, Login(user=user, password=password), patience))


@pytest.mark.conforms("N-32")
def test_each_user_may_do_so_much() -> None:
    with offered(access=Access(users=USERS)) as place, place.here() as here:
        running(here)
        with as_user(place, "eve", "ear") as eve, as_user(place, "bob", "pass") as bob:
            heard = channel(eve, 1, transmit=0)
            with pytest.raises(
                HubError, match=r"SetUpChannel needs the right to send .* eve may only listen"
            ):
                eve.open_channel(eve.boards()[1].id, 0).set_up(ChannelMode(receive=1, transmit=1))
            sender = channel(bob, 0)
            sender.send(Frame(0x42))
            frame = heard.receive(LONG_S)
            assert frame is not None
            assert frame.id == 0x42
            for hub in (eve, bob):
                with pytest.raises(HubError, match=r"OpenControl needs the right to configure"):
                    hub.open_control(hub.boards()[0].id, 0)
        with as_user(place, "alice", "secret") as alice:
            alice.unplug("HW000002")


@pytest.mark.conforms("N-32")
@pytest.mark.finding("machines 7")
@pytest.mark.parametrize("may", [access.LISTEN, access.SEND])
def test_nobody_else_is_shut_out_by_who_may_not_configure(may: str) -> None:
    for request in (m.OpenChannel(1, 0, True), m.OpenMonitor(1, 0, True)):
        with pytest.raises(HubError, match="needs the right to configure"):
            access.check("eve", may, request)
        access.check("alice", access.CONFIGURE, request)
    access.check("eve", may, m.OpenChannel(1, 0, False))


@pytest.mark.conforms("N-32")
def test_who_is_not_known_is_not_let_in() -> None:
    soon = QUICK._replace(connect_s=0.3)
    with offered(access=Access(users=USERS)) as place:
        with pytest.raises(HubLost, match="does not let alice with this password in"):
            as_user(place, "alice", "wrong", soon)
        with pytest.raises(HubLost, match="does not let anyone without a name in"):
            elsewhere(place.address, soon)


@contextmanager
def silent(place: Place, count: int) -> Iterator[None]:
    """So many connections that say nothing."""
    with ExitStack() as closing:
        for _ in range(count):
            closing.enter_context(socket.create_connection(("127.0.0.1", place.port)))
        yield


@pytest.mark.finding("machines 8")
def test_silent_connections_keep_nobody_out() -> None:
    with (
        offered(access=Access(users=USERS)) as place,
        silent(place, 150),
        as_user(place, "eve", "ear") as eve,
    ):
        assert eve.boards()


@pytest.mark.finding("machines 8")
def test_who_finds_no_room_is_not_told_of_a_password(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(settings, "_STRANGERS", 2)
    soon = QUICK._replace(connect_s=0.1)
    with (
        offered(access=Access(users=USERS)) as place,
        silent(place, 8),
        pytest.raises(HubLost, match="others use all that it accepts"),
    ):
        as_user(place, "eve", "ear", soon)


@pytest.mark.finding("machines 14")
def test_who_is_far_away_has_longer_to_connect(monkeypatch: pytest.MonkeyPatch) -> None:
    """300 ms one way: a handshake there and back three times took longer than all that was granted."""
    granted: list[int] = []
    monkeypatch.setattr(settings, "round_trip_s", lambda endpoint: 0.6)
    monkeypatch.setattr(settings, "open_session", lambda asked: granted.append(asked["connect/timeout_ms"]))
    open_for_client(for_client("tcp/127.0.0.1:1", Login()))
    assert granted == [4_500]


def test_a_user_cannot_take_another_one_s_keys(monkeypatch: pytest.MonkeyPatch) -> None:
    """The rights go by keys, and Zenoh's access list says whose those are: a client that lies is not heard."""
    with offered(access=Access(users=USERS)) as place:
        login = Login(user="eve", password="ear")
        monkeypatch.setattr(
            NetworkLink, "_user", property(lambda self: "alice", lambda self, user: None), raising=False
        )
        with pytest.raises(HubLost, match="no message from"):
            NetworkLink(place.address, "liar", login, QUICK._replace(call_s=0.4))


@pytest.mark.conforms("N-32")
def test_every_request_needs_one_of_the_rights() -> None:
    assert access.needed(m.ListBoards()) == access.LISTEN
    assert access.needed(m.JoinTime("1-a", 0, "a")) == access.SEND  # everybody waits for who takes part
    assert access.needed(m.CreateFifo(1, 1)) == access.SEND
    assert access.needed(m.Unplug("HW000001")) == access.CONFIGURE
    assert access.needed(m.Disturb("can0", True)) == access.CONFIGURE
    kinds = set(access._LISTENING) & set(access._SENDING)
    assert not kinds


def certificate(folder: Path, name: str) -> Tls:
    """PEM files of this name, signed by the authority of the same folder."""
    ca, key, signed = folder / "ca.pem", folder / f"{name}.key", folder / f"{name}.pem"
    new = [
        "openssl",
        "req",
        "-newkey",
        "ec",
        "-pkeyopt",
        "ec_paramgen_curve:prime256v1",
        "-nodes",
        "-days",
        "2",
    ]

    def run(*words: str) -> None:
        subprocess.run(words, check=True, capture_output=True, timeout=LONG_S)

    if not ca.exists():
        run(*new, "-x509", "-subj", "/CN=authority", "-keyout", str(folder / "ca.key"), "-out", str(ca))
    names = folder / "names"
    names.write_text("subjectAltName=DNS:localhost,IP:127.0.0.1\n")
    asked = folder / f"{name}.csr"
    run(*new, "-subj", f"/CN={name}", "-keyout", str(key), "-out", str(asked))
    run("openssl", "x509", "-req", "-in", str(asked), "-CA", str(ca), "-CAkey", str(folder / "ca.key"), "-days", "2",
        "-CAcreateserial", "-extfile", str(names), "-out", str(signed))  # fmt: skip
    return Tls(ca=str(ca), certificate=str(signed), key=str(key))


def test_mutual_tls_says_who_is_who(tmp_path: Path) -> None:
    port = free_port()
    doors = Access(users={"alice": User(may="listen")}, tls=certificate(tmp_path, "bench"))
    with offered(access=doors, listen=(f"tls/localhost:{port}",)):
        address = f"zenoh://tests/bench?via=tls/localhost:{port}"
        own = certificate(tmp_path, "alice")
        with Hub(NetworkLink(address, "a", Login(user="alice", tls=own))) as hub:
            assert hub.boards()
            with pytest.raises(HubError, match="alice may only listen"):
                hub.unplug("HW000001")
        with pytest.raises(HubLost):  # a good certificate, of somebody who is on no list
            NetworkLink(address, "m", Login(user="mallory", tls=certificate(tmp_path, "mallory")))
        with pytest.raises(HubLost):
            NetworkLink(address, "n", Login())


@pytest.mark.conforms("N-32")
@each("endpoint", ["tcp/0.0.0.0:7449", "tcp/192.168.1.5:7449", "tcp/bench1:7449", "tcp/[::]:7449"])
def test_other_machines_come_in_by_name_or_because_it_was_typed(endpoint: str) -> None:
    with pytest.raises(BadValue, match="--access FILE with users, or --insecure"):
        check_reach((endpoint,), None, insecure=False)
    check_reach((endpoint,), None, insecure=True)
    check_reach((endpoint,), Access(users=USERS), insecure=False)
    check_reach(("tcp/127.0.0.1:7449", "tcp/[::1]:7449", "tcp/localhost:7449"), None, insecure=False)


BEHIND = Access(users=USERS, router=Router(user="bench", password="own"))


@pytest.mark.finding("machines 1")
@each(
    ("listen", "doors", "complaint"),
    [
        ((), None, "--access FILE with users and \\[router\\].* or --insecure"),
        ((), Access(users=USERS), "needs \\[router\\]"),
        (("tcp/127.0.0.1:1",), BEHIND, "offer the hub twice"),
    ],
)
def test_a_router_opens_nothing_that_nobody_asked_to_open(
    listen: tuple[str, ...], doors: Access | None, complaint: str
) -> None:
    via = ("tcp/127.0.0.1:7447",)  # the router itself may listen anywhere
    with (
        pytest.raises(BadValue, match=complaint),
        offered(listen=listen, via=via, access=doors),
    ):
        pass


@each("names", [{"realm": "a/b"}, {"name": "a/b"}])
def test_a_name_that_is_none_is_refused_before_anything_is_opened(names: dict[str, str]) -> None:
    with (
        socket.create_server(("127.0.0.1", 0)) as taken,
        pytest.raises(BadValue, match=f"{next(iter(names))} 'a/b': 1 to 64 letters, digits"),
        offered(listen=(f"tcp/127.0.0.1:{taken.getsockname()[1]}",), **names),
    ):
        pass


@contextmanager
def routing(doors: Access) -> Iterator[str]:
    """A router in this process, as `canwire router` is one; its endpoint."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with closing(open_for_hub(for_router((endpoint,), doors), doors)):
        yield endpoint


@pytest.mark.conforms("N-32")
@pytest.mark.finding("machines 1")
def test_rights_hold_behind_a_router(monkeypatch: pytest.MonkeyPatch) -> None:
    with routing(BEHIND) as endpoint, offered(listen=(), via=(endpoint,), access=BEHIND) as place:
        there = place._replace(port=int(endpoint.rpartition(":")[2]))
        assert there.bridge.address == there.address
        with there.here() as here, as_user(there, "eve", "ear") as eve, as_user(there, "bob", "pass") as bob:
            running(here)
            heard, sender = channel(eve, 1, transmit=0), channel(bob, 0)
            sender.send(Frame(0x42))
            frame = heard.receive(LONG_S)
            assert frame is not None
            assert frame.id == 0x42
            with pytest.raises(HubError, match="eve may only listen"):
                eve.unplug("HW000001")
        monkeypatch.setattr(
            NetworkLink, "_user", property(lambda self: "alice", lambda self, user: None), raising=False
        )
        with pytest.raises(HubLost, match="no message from"):
            NetworkLink(there.address, "liar", Login(user="eve", password="ear"), QUICK._replace(call_s=0.4))


@pytest.mark.finding("machines 1")
def test_a_router_that_asks_nobody_is_not_joined_with_users() -> None:
    """Zenoh's own end of it: who comes with a password is not let in where nobody asks for one."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    plain = {**usual(LEASE_S), "mode": "router", "listen/endpoints": [endpoint]}
    soon = {**for_hub((), (endpoint,), BEHIND), "connect/timeout_ms": 300}
    with closing(open_session(plain)), pytest.raises(HubError, match=r"does not let \[router\]'s user in"):
        open_for_hub(soon, BEHIND)


@pytest.mark.finding("machines 11")
@each(
    ("listen", "via", "shown"),
    [
        (("tcp/0.0.0.0:7449",), (), "zenoh://lab/b.example"),
        (("tcp/[::]:7450",), (), "zenoh://lab/b.example:7450"),
        (("tls/0.0.0.0:7447",), (), "zenoh://lab/bench1?via=tls/b.example:7447"),
        (("tcp/10.0.0.5:7449",), (), "zenoh://lab/10.0.0.5"),
        ((), ("tcp/10.0.0.7:7447",), "zenoh://lab/bench1?via=tcp/10.0.0.7:7447"),
    ],
)
def test_the_address_that_is_shown_is_one_to_connect_to(
    listen: tuple[str, ...], via: tuple[str, ...], shown: str
) -> None:
    offer = keys.Offer("lab", "bench1", "1c73", 6, "real")
    assert keys.address_of(offer, listen, via, "b.example") == shown
    assert keys.parse(shown).realm == "lab"


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (
            '[users.a]\nmay = "send"\npassword = "x"\n[users.b]\nmay = "send"\n'
            '[tls]\nca = "c"\ncertificate = "c"\nkey = "k"\n',
            "b without a password beside others .* keep two files",
        ),
        ('[users.a]\nmay = "send"\npassword = "x"\n[router]\nuser = "a"\npassword = "y"\n', "own name"),
        ("[users.alice]\n", "may"),
        ('[users.alice]\nmay = "everything"\n', "everything"),
        ('[users.alice]\nmay = "send"\n', "needs a password"),
        ('[users."a/b"]\nmay = "send"\npassword = "x"\n', "users"),
        ('[users.alice]\nmay = "send"\npassword = "a:b"\n', "password"),
        ("[users", "table declaration"),
    ],
)
def test_a_bad_file_is_refused_with_the_place(tmp_path: Path, text: str, complaint: str) -> None:
    path = tmp_path / "lab.toml"
    path.write_text(text)
    with pytest.raises(BadConfig, match=complaint):
        access.load(Access, str(path))


def test_paths_of_certificates_count_from_the_file(tmp_path: Path) -> None:
    path = tmp_path / "me.toml"
    path.write_text('user = "alice"\n[tls]\nca = "ca.pem"\ncertificate = "a.pem"\nkey = "/etc/a.key"\n')
    assert access.load(Login, str(path)).tls == Tls(
        ca=str(tmp_path / "ca.pem"), certificate=str(tmp_path / "a.pem"), key="/etc/a.key"
    )


# hazards, as measured: shared/libraries.md


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("scouting/multicast/enabled", False),
        ("scouting/gossip/enabled", False),
        ("transport/shared_memory/enabled", False),
        ("transport/unicast/max_sessions", SESSIONS),
        ("transport/unicast/accept_pending", 2_000),
        ("transport/unicast/accept_timeout", 3_000),
        ("transport/link/tx/lease", 10_000),
        ("transport/link/tx/queue/size/data", 16),
        ("transport/link/tx/queue/congestion_control/drop/wait_before_drop", 1_000),
        ("transport/link/tx/queue/congestion_control/block/wait_before_close", 3_600_000_000),
    ],
)
def test_zenoh_is_set_up_as_it_should_be(key: str, value: object) -> None:
    """Zenoh refuses keys it does not know; what it has then is what was asked for."""
    config = load_zenoh().Config()
    for made in (usual(LEASE_S), for_client("tcp/a:1", Login()), for_hub(("tcp/127.0.0.1:1",), (), None)):
        for name, given in made.items():
            config.insert_json5(name, json.dumps(given))
        assert json.loads(config.get_json(key)) == value


def listeners() -> set[str]:
    """Local addresses, in hex, of this machine's TCP listeners and UDP sockets that belong to this process."""
    own = {
        path.readlink().name for path in Path("/proc/self/fd").iterdir() if path.is_symlink() and _inode(path)
    }
    found = set()
    for kind, states in (("tcp", {"0A"}), ("tcp6", {"0A"}), ("udp", {"07", "01"}), ("udp6", {"07", "01"})):
        for line in Path(f"/proc/self/net/{kind}").read_text().splitlines()[1:]:
            words = line.split()
            if words[3] in states and f"socket:[{words[9]}]" in own:
                found.add(f"{kind} {words[1]}")
    return found


def _inode(path: Path) -> bool:
    try:
        return str(path.readlink()).startswith("socket:")
    except OSError:
        return False


@pytest.mark.conforms("N-32")
def test_it_listens_where_it_was_told_and_nowhere_else() -> None:
    before = listeners()
    with offered() as place:
        told = {f"tcp 0100007F:{place.port:04X}"}
        # The portable variant listens for a moment where it makes a pair of sockets.
        until(lambda: listeners() - before == told)
        with canwire.connect(place.address):
            until(lambda: listeners() - before == told)


def test_many_hubs_are_all_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Zenoh's usual channel for replies hung at 800."""
    monkeypatch.setattr(discovery, "_LOOK_S", LONG_S)
    with offered() as place:
        session = place.bridge._session
        tokens = [
            session.liveliness().declare_token(f"canwire/many/hub/h{number}/i{number}/2/fast")
            for number in range(1200)
        ]
        assert len(canwire.offered_hubs(f"tcp/127.0.0.1:{place.port}", "many")) == 1200
        for token in tokens:
            token.undeclare()


@pytest.mark.realtime
def test_hubs_come_and_go() -> None:
    with offered() as place:
        endpoint = f"tcp/127.0.0.1:{place.port}"
        assert [offer.name for offer in canwire.offered_hubs(endpoint)] == ["bench"]
        with offered(name="other", via=(endpoint,), insecure=True):
            until(lambda: [offer.name for offer in canwire.offered_hubs(endpoint)] == ["bench", "other"])
        until(lambda: [offer.name for offer in canwire.offered_hubs(endpoint)] == ["bench"])
