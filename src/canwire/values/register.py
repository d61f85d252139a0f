"""A register of a chip for display."""

from __future__ import annotations

from canwire.values.frozen import dataclass


@dataclass(frozen=True, slots=True)
class RegisterValue:
    """The present value of one register of a chip; `text` describes its bits."""

    name: str
    address: int
    value: int
    text: str
