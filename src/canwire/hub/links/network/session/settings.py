"""The settings of Zenoh, and the reasons: each follows from a measurement or from the manual of Zenoh.

Nothing here waits for long: payloads that do not fit a full queue are dropped, and sent again by this package.
"""

from __future__ import annotations

import ipaddress
import json
import os
import tempfile
from typing import Any, NamedTuple

from canwire.errors import BadValue, ExtraMissing, HubError, HubLost
from canwire.hub.links.network.access import Access, Login, Router, Tls, User
from canwire.hub.links.network.session.door import Door, at_the_door, host_and_port, round_trip_s

SESSIONS = 1_000  # machines or programs that one hub lets in
CONNECT_S = 1.5  # and so many times the way there and back more
_ROUNDS = 5
_ROUTER_S = 5.0
_STRANGERS = 2_000  # connections without a login; with Zenoh's own 100, a hundred silent connections ...
_STRANGER_MS = 3_000  # ... kept all programs out for 10 s
LEASE_S = 10.0  # silence of the other machine after which Zenoh gives a connection up ...
CUT_S = 30.0  # ... and how much longer both ends keep open handles: cuts of 30 s, and the time to reconnect
TIMED_SILENCE_S = 30.0  # each end of a program in lockstep bears as much: no result depends on a busy machine
_ALL = ["put", "delete", "declare_subscriber", "query", "reply", "declare_queryable"]
_TOKENS = ["liveliness_token", "liveliness_query", "declare_liveliness_subscriber"]
_BOTH = ["ingress", "egress"]

Settings = dict[str, Any]


class Patience(NamedTuple):
    """How long silence is tolerated: by a call, by one of a program in lockstep, by a link whose connection is broken
    or was dropped as silent, and by a connection attempt."""

    call_s: float = 1.7
    timed_s: float = TIMED_SILENCE_S
    broken_s: float = 1.5
    lease_s: float = LEASE_S
    cut_s: float = CUT_S
    connect_s: float = CONNECT_S


def load_zenoh() -> Any:
    """The library, loaded on first use because that takes 20 ms; raises ExtraMissing."""
    try:
        import zenoh
    except ImportError:
        raise ExtraMissing("eclipse-zenoh", "network") from None
    return zenoh


def usual(lease_s: float) -> Settings:
    """The settings that both ends have in common."""
    queue = "transport/link/tx/queue/congestion_control"
    return {
        "scouting/multicast/enabled": False,  # otherwise every machine of the network gets announcements and requests
        "scouting/gossip/enabled": False,
        "transport/shared_memory/enabled": False,  # on by default; stopped a router at 351 sessions
        "transport/unicast/max_sessions": SESSIONS,
        "transport/unicast/accept_pending": _STRANGERS,
        "transport/unicast/accept_timeout": _STRANGER_MS,
        "transport/link/tx/lease": round(lease_s * 1000),
        "transport/link/tx/queue/size/data": 16,  # of 64 KiB: a window (mirrors.py) fits, and so nothing is dropped
        # a full queue: neither wait for long (who calls has better things to do) nor hang up, usual after 5 s
        f"{queue}/drop/wait_before_drop": 1_000,  # microseconds
        f"{queue}/block/wait_before_close": 3_600_000_000,
        "connect/retry": {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 2.0},
    }


def for_client(
    endpoint: str, login: Login, lease_s: float = LEASE_S, connect_s: float = CONNECT_S
) -> Settings:
    """A program's session: it listens nowhere."""
    return {
        **usual(lease_s),
        "mode": "client",
        "connect/endpoints": [endpoint],
        "connect/timeout_ms": round(connect_s * 1000),
        "connect/exit_on_failure": True,
        **_credentials(login.user, login.password),
        **(_tls(login.tls, "connect") if login.tls is not None else {}),
    }


def for_hub(
    listen: tuple[str, ...], via: tuple[str, ...], access: Access | None, lease_s: float = LEASE_S
) -> Settings:
    """A hub's session: it listens at the given endpoints only, or it joins routers, which keep the access lists."""
    settings = {
        **usual(lease_s),
        "mode": "peer",
        "listen/endpoints": list(listen),
        "connect/endpoints": list(via),
    }
    if via:
        settings |= {"connect/timeout_ms": round(_ROUTER_S * 1000), "connect/exit_on_failure": True}
    if access is not None and via:
        own = access.router
        settings |= _credentials(own.user, own.password) if own is not None else {}
        settings |= _tls(access.tls, "connect") if access.tls is not None else {}
    elif access is not None:
        settings |= _asking(access)
    return settings


def for_router(listen: tuple[str, ...], access: Access, lease_s: float = LEASE_S) -> Settings:
    """A router that authenticates all connections: of users, as at a hub, and of hubs by the name in [router]."""
    return {**usual(lease_s), "mode": "router", "listen/endpoints": list(listen), **_asking(access)}


def _asking(access: Access) -> Settings:
    """The settings with which a listening session admits only these users, each to separate keys."""
    tls = _tls(access.tls, "listen") if access.tls is not None else {}
    return {"access_control": rules(access.users, access.router), **tls}


def rules(users: dict[str, User], hub: Router | None = None) -> Settings:
    """Each user may use separate keys and see the list of hubs, but no keys of other users and nothing else.

    A `hub` at a router has the keys of all users.
    """
    own = [_rule(user, _ALL + _TOKENS, f"canwire/*/to/*/{user}/**") for user in users]
    everybody = _rule("hubs ", _TOKENS, "canwire/*/hub/**")  # no user's name has a space
    subjects = [{"id": user, _told_by(what): [user]} for user, what in users.items()]
    policies = [{"rules": [user, everybody["id"]], "subjects": [user]} for user in users]
    if hub is not None:
        own.append(_rule("all ", _ALL + _TOKENS, "canwire/*/to/**"))
        subjects.append({"id": "hub ", _told_by(hub): [hub.user]})
        policies.append({"rules": ["all ", everybody["id"]], "subjects": ["hub "]})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": [*own, everybody],
        "subjects": subjects,
        "policies": policies,
    }


def check_reach(
    listen: tuple[str, ...],
    access: Access | None,
    *,
    via: tuple[str, ...] = (),
    insecure: bool,
    relay: tuple[str, ...] = (),
) -> None:
    """Raises BadValue for an endpoint open to every program on the network, unless that was requested."""
    if relay:
        target_of(listen)
    if access is not None:
        _check_routers(listen, via, access)
        return
    if insecure:
        return
    for endpoint in via:
        raise BadValue(
            f"{endpoint}: every program that reaches that router would reach this hub without authentication; "
            "give --access FILE with users and [router], where the router is `canwire router --access FILE` or one "
            "with such a list, or --insecure"
        )
    for endpoint in (*listen, *relay):
        if not _is_loopback(endpoint):
            raise BadValue(
                f"{endpoint}: other machines reach it, and would need no authentication; give --access FILE "
                "with users, or --insecure"
            )


def target_of(listen: tuple[str, ...]) -> str:
    """The endpoint of a hub that relays connect programs to, which asks who they are; raises BadValue."""
    found = next((endpoint for endpoint in listen if endpoint.startswith("tcp/")), None)
    if found is None:
        raise BadValue(
            f"{', '.join(listen) or 'a router alone'}: a relay needs a hub that listens at tcp/ADDRESS:PORT; "
            "what TLS has encrypted is never twice the same, and could not be sent once for all programs of a machine"
        )
    return found.replace("tcp/0.0.0.0:", "tcp/127.0.0.1:").replace("tcp/[::]:", "tcp/[::1]:")


def _check_routers(listen: tuple[str, ...], via: tuple[str, ...], access: Access) -> None:
    """With an access list, either the hub or the router authenticates users, not both."""
    if via and listen:
        raise BadValue(
            f"{via[0]} and {listen[0]} with --access: behind a router only the router can authenticate users; "
            "offer the hub twice (`canwire offer`), once with --via and once with --listen"
        )
    if via and access.router is None:
        raise BadValue(
            f"{via[0]}: the file of --access needs [router] with user and password, which the router checks; "
            "for a router without authentication, give --insecure and no --access"
        )


def open_session(settings: Settings) -> Any:
    """A session of Zenoh's; raises its ZError."""
    zenoh = load_zenoh()
    config = zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


def open_for_hub(settings: Settings, access: Access | None) -> Any:
    """A hub's session or a router's; raises HubError where it cannot listen or connect."""
    zenoh = load_zenoh()
    with tempfile.TemporaryDirectory() as place:  # for this user's eyes alone, and gone once it was read
        passwords = _passwords(access) if access is not None and settings["listen/endpoints"] else {}
        if passwords:
            path = os.path.join(place, "passwords")
            with open(path, "w", encoding="utf-8", newline="\n") as file:
                file.writelines(f"{name}:{password}\n" for name, password in passwords.items())
            settings = {**settings, "transport/auth/usrpwd/dictionary_file": path}
            settings |= _credentials("hub", os.urandom(16).hex())
        try:
            return open_session(settings)
        except zenoh.ZError as error:
            via = settings.get("connect/endpoints", [])
            where = ", ".join([*settings["listen/endpoints"], *via])
            asked = (
                "; no program answers there, or it does not let [router]'s user in" if via and access else ""
            )
            raise HubError(f"{where}: {_reason(error)}{asked}") from None


def _passwords(access: Access) -> dict[str, str]:
    """The passwords of all users that have one."""
    found = {name: user.password for name, user in access.users.items() if user.password}
    own = access.router
    return found | ({own.user: own.password} if own is not None and own.password else {})


def open_for_client(settings: Settings) -> Any:
    """A program's session; raises HubLost if no hub or router answers or admits this program."""
    zenoh = load_zenoh()
    endpoint = settings["connect/endpoints"][0]
    far_ms = round(1000 * _ROUNDS * round_trip_s(endpoint))
    try:
        return open_session({**settings, "connect/timeout_ms": settings["connect/timeout_ms"] + far_ms})
    except zenoh.ZError as error:
        met = at_the_door(endpoint)
        if met is Door.FULL:
            raise HubLost(
                f"{endpoint}: a program listens, but closes every connection: others use all that it accepts at a "
                "time; try again, or find these clients on that machine"
            ) from None
        if met is Door.OPEN:
            user = settings.get("transport/auth/usrpwd/user", "")
            who = f"{user} with this password" if user else "anyone without a name"
            raise HubLost(
                f"{endpoint}: a program listens but does not let {who} in (CANWIRE_NETWORK names the file with user, "
                f"password and certificates); or it is no hub"
            ) from None
        raise HubLost(
            f"{endpoint}: no program answers; is `canwire serve --network` running there? ({_reason(error)})"
        ) from None


def _rule(name: str, messages: list[str], key: str) -> Settings:
    return {"id": name, "messages": messages, "flows": _BOTH, "permission": "allow", "key_exprs": [key]}


def _told_by(user: User | Router) -> str:
    """How a user is identified: by a password, or by the name in a certificate."""
    return "usernames" if user.password else "cert_common_names"


def _credentials(user: str, password: str) -> Settings:
    if not password:
        return {}
    return {"transport/auth/usrpwd/user": user, "transport/auth/usrpwd/password": password}


def _tls(tls: Tls, side: str) -> Settings:
    """Mutual: each end shows a certificate that the same authority has signed."""
    return {
        "transport/link/tls": {
            "root_ca_certificate": tls.ca,
            f"{side}_certificate": tls.certificate,
            f"{side}_private_key": tls.key,
            "enable_mtls": True,
        }
    }


def _is_loopback(endpoint: str) -> bool:
    host, _ = host_and_port(endpoint)
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _reason(error: Exception) -> str:
    """Zenoh's words without the place in its sources."""
    return str(error).partition(" at /")[0]
