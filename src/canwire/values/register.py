"""A register of a chip for display."""

from __future__ import annotations

from canwire.values.frozen import dataclass


@dataclass(frozen=True, slots=True)
class RegisterValue:
    """One register of a chip as it is now; `text` describes its bits."""

    name: str
    address: int
    value: int
    text: str
