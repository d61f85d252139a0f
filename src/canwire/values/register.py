"""A register of a chip, as somebody who looks at it sees it."""

from __future__ import annotations

from canwire.values.frozen import dataclass


@dataclass(frozen=True, slots=True)
class RegisterValue:
    """One register of a chip as it is now; `text` says what its bits mean."""

    name: str
    address: int
    value: int
    text: str
