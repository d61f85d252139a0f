"""The base class of all messages between a client and its hub."""

from __future__ import annotations

import msgspec


class Message(msgspec.Struct, tag=True, array_like=True, forbid_unknown_fields=True):
    """A message between a client and its hub."""
