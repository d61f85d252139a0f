"""Hardware ids of boards: those in use, and the lowest free one."""

from __future__ import annotations

from collections.abc import Iterable

from canwire.errors import BadValue


class Serials:
    """The ids of the boards that are plugged in; a `reserved` id is only used if it is requested."""

    def __init__(self, reserved: Iterable[str]) -> None:
        self._reserved = set(reserved)
        self._taken: set[str] = set()
        self._lowest = 1  # every number below is taken or reserved

    def __contains__(self, serial: str) -> bool:
        return serial in self._taken

    def check(self, serial: str) -> str:
        """Return this id; raises BadValue if a board with it is plugged in."""
        if serial in self._taken:
            raise BadValue(f"a board {serial} is plugged in already")
        return serial

    def free(self) -> str:
        """The id with the lowest free number."""
        while (serial := f"HW{self._lowest:06}") in self._taken or serial in self._reserved:
            self._lowest += 1
        return serial

    def take(self, serial: str) -> None:
        """A board with this id was plugged in."""
        self._taken.add(serial)

    def give_back(self, serial: str) -> None:
        """The board with this id was pulled out."""
        self._taken.discard(serial)
        digits = serial.removeprefix("HW")
        if digits.isascii() and digits.isdigit() and f"HW{int(digits):06}" == serial:
            self._lowest = max(1, min(self._lowest, int(digits)))
