"""[limits] in canwire.toml: limits for each client, so that a faulty client harms only itself."""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec import Meta


class LimitsConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """[limits]: a client is one connection; `connections` limits the connections of one process."""

    connections: Annotated[
        int, Meta(ge=1, le=1_000_000, description="connections of one process at a time")
    ] = 1_024
    channels: Annotated[
        int, Meta(ge=1, le=1_000_000, description="CAN channels and LIN monitors of one client")
    ] = 16_384
    fifos: Annotated[int, Meta(ge=1, le=1_000_000, description="FIFO ends that one client has open")] = 16_384
    leases: Annotated[
        int, Meta(ge=1, le=1_000_000, description="controls, cyclic lists, layers and shares of one client")
    ] = 65_536
    boards: Annotated[
        int, Meta(ge=1, le=1_000_000, description="boards that one client has plugged in and not removed")
    ] = 16_384
    notes: Annotated[
        int, Meta(ge=1, le=1_000_000, description="notes of one client; 4 times as many of closed clients")
    ] = 256
    waiting_bytes: Annotated[
        int,
        Meta(ge=1 << 22, le=1 << 30, description="bytes sent to a client that it has not read yet"),
    ] = 1 << 22
    greeting_seconds: Annotated[
        int, Meta(ge=1, le=86_400, description="seconds until a new connection must have identified itself")
    ] = 30


LIMITS = "limits"
