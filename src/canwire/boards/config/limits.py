"""canwire.toml's [limits]: how much one client may have of a hub, so that one that takes without end harms itself."""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec import Meta


class LimitsConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """[limits]: a client is one connection; `connections` counts those of one process."""

    connections: Annotated[
        int, Meta(ge=1, le=1_000_000, description="connections of one process at a time")
    ] = 1_024
    channels: Annotated[
        int, Meta(ge=1, le=1_000_000, description="CAN channels and LIN monitors of one client")
    ] = 16_384
    fifos: Annotated[int, Meta(ge=1, le=1_000_000, description="ends of FIFOs that one client has open")] = (
        16_384
    )
    leases: Annotated[
        int, Meta(ge=1, le=1_000_000, description="controls, cyclic lists, layers and shares of one client")
    ] = 65_536
    boards: Annotated[
        int, Meta(ge=1, le=1_000_000, description="boards that one client has plugged in and are still there")
    ] = 16_384
    notes: Annotated[
        int, Meta(ge=1, le=1_000_000, description="notes of one client; 4 times as many of clients that left")
    ] = 256
    waiting_bytes: Annotated[
        int,
        Meta(ge=1 << 22, le=1 << 30, description="bytes that may wait for a client to read them"),
    ] = 1 << 22
    greeting_seconds: Annotated[
        int, Meta(ge=1, le=86_400, description="seconds that a connection may take to say who it is")
    ] = 30


LIMITS = "limits"
