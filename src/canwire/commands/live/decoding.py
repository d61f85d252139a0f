"""Names and signals of frames by a database."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from canwire import Frame

if TYPE_CHECKING:
    from canwire import DecodedMessage

Decode = Callable[[Frame], "DecodedMessage | None"]


def decoder(path: str) -> Decode:
    """Of a DBC, KCD, SYM or ARXML file; gives None for frames that it does not know.

    Raises BadDescription, ExtraMissing without canwire[databases].
    """
    from canwire import load_database

    return load_database(path).decode


def ids_of_messages(path: str, names: Sequence[str]) -> list[tuple[int, int, bool]]:
    """Identifier, mask and whether it has 29 bits, of these messages; raises BadValue with near names."""
    from canwire import load_database

    database = load_database(path)
    return [one for name in names for one in database.id_masks(name)]
