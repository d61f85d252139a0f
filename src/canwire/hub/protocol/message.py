"""What all messages between a client and its hub have in common."""

from __future__ import annotations

import msgspec


class Message(msgspec.Struct, tag=True, array_like=True, forbid_unknown_fields=True):
    """Anything on the wire."""
