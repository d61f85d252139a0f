"""Sends payloads without waiting: a payload that cannot be sent is dropped, and the mirrors send it again."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any

from canwire.hub.links.network.session.settings import load_zenoh

_LARGE = 4_096  # bytes: such batches may share a packet with the next one, smaller ones are sent immediately


def sender(session: Any, key: str) -> Callable[[bytes], None]:
    """Sends payloads under this key, from any thread; nothing once the session is closed."""
    zenoh = load_zenoh()
    drop = zenoh.CongestionControl.DROP
    quick = session.declare_publisher(key, congestion_control=drop, express=True)
    many = session.declare_publisher(key, congestion_control=drop, express=False)

    def send(payload: bytes) -> None:
        with contextlib.suppress(zenoh.ZError):
            (many if len(payload) > _LARGE else quick).put(payload)

    return send
