"""Probes an endpoint with a plain TCP connection: the round-trip time, and why a client may have been refused."""

from __future__ import annotations

import enum
import socket
import time

from canwire.errors import BadValue

_CONNECT_S = 2.0
_LOOK_S = 0.3


class Door(enum.Enum):
    """The service that a TCP connection reaches at an endpoint."""

    NONE = "no program listens"
    FULL = "a connection is closed immediately"
    OPEN = "a program waits for the first message"


def at_the_door(endpoint: str) -> Door:
    """Connect to this endpoint, and return what happens."""
    try:
        with socket.create_connection(host_and_port(endpoint), _CONNECT_S) as end:
            end.settimeout(_LOOK_S)
            try:
                return Door.OPEN if end.recv(1) else Door.FULL
            except TimeoutError:
                return Door.OPEN
            except ConnectionError:
                return Door.FULL
    except OSError:
        return Door.NONE


def round_trip_s(endpoint: str) -> float:
    """The round-trip time to an endpoint in s; 0 if no program listens."""
    began_s = time.monotonic()
    try:
        socket.create_connection(host_and_port(endpoint), _CONNECT_S).close()
    except OSError:
        return 0.0
    return time.monotonic() - began_s


def host_and_port(endpoint: str) -> tuple[str, int]:
    """Host and port of an endpoint such as tcp/192.168.1.5:7449; raises BadValue."""
    host, _, port = endpoint.partition("/")[2].partition("?")[0].partition("#")[0].rpartition(":")
    if not host or not port.isdecimal():
        raise BadValue(f"{endpoint!r}: PROTOCOL/ADDRESS:PORT, such as tcp/192.168.1.5:7449")
    return host.strip("[]"), int(port)
