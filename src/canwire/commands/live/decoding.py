"""Names and signals of frames by a database."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from canwire import Frame

if TYPE_CHECKING:
    from canwire import DecodedMessage


class Decode(Protocol):
    """None for frames that are not known on this channel; "" is a channel without a name."""

    def __call__(self, frame: Frame, channel: str = "") -> DecodedMessage | None: ...


def decoder(path: str) -> Decode:
    """A decoder by a DBC, KCD, SYM or ARXML file, for every channel; raises BadDescription, ExtraMissing."""
    from canwire import load_database

    database = load_database(path)

    def decode(frame: Frame, channel: str = "") -> DecodedMessage | None:
        return database.decode(frame)

    return decode
