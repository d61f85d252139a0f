"""Values that people typed into fields: all of them are checked before anything is changed."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping

Word = Callable[..., str]


class BadFields(Exception):
    """Invalid fields, with a message for each."""

    def __init__(self, faults: Mapping[str, str]) -> None:
        self.faults = dict(faults)
        super().__init__(self.faults)  # pickle calls `__init__` with these arguments

    def __str__(self) -> str:
        return ", ".join(f"{name}: {text}" for name, text in self.faults.items())


class Fields:
    """The fields of one form. An invalid field is noted and a meaningless value returned; `check` raises all faults."""

    def __init__(self, values: Mapping[str, str], word: Word) -> None:
        self._values = values
        self._word = word
        self._faults: dict[str, str] = {}

    @property
    def given(self) -> Mapping[str, str]:
        """All fields, unchecked."""
        return self._values

    def fault(self, name: str, message: str) -> None:
        """Note a fault of a field; only the first fault of each field is kept."""
        self._faults.setdefault(name, message)

    def check(self) -> None:
        """Raise BadFields if any field was invalid so far."""
        if self._faults:
            raise BadFields(self._faults)

    def text(self, name: str, *, longest: int = 200, empty: bool = True) -> str:
        value = self._values.get(name, "").strip()
        if len(value) > longest:
            self.fault(name, self._word("base.too-long", most=longest))
        elif not value and not empty:
            self.fault(name, self._word("base.needed"))
        return value[:longest]

    def flag(self, name: str) -> bool:
        """Return whether a check box is checked."""
        return self._values.get(name, "") in ("on", "true", "1")

    def choice(self, name: str, choices: Collection[str]) -> str:
        value = self.text(name)
        if value not in choices:
            self.fault(name, self._word("base.no-choice", value=value[:40]))
        return value

    def whole(self, name: str, least: int, most: int) -> int:
        """Return a decimal number from `least` to `most`."""
        value = self.text(name)
        if not re.fullmatch(r"-?[0-9]{1,12}", value):
            self.fault(name, self._word("base.no-number", value=value[:40], least=least, most=most))
            return least
        return self._within(name, int(value), least, most, str)

    def real(self, name: str, least: float, most: float) -> float:
        """Return a decimal fraction; its decimal point may be a comma."""
        value = self.text(name).replace(",", ".")
        if not re.fullmatch(r"-?(?:[0-9]{1,12}(?:\.[0-9]{0,9})?|\.[0-9]{1,9})", value):
            self.fault(
                name, self._word("base.no-number", value=value[:40], least=f"{least:g}", most=f"{most:g}")
            )
            return least
        number = float(value)
        if not least <= number <= most:
            self.fault(
                name, self._word("base.out-of-range", value=value, least=f"{least:g}", most=f"{most:g}")
            )
            return least
        return number

    def hexadecimal(self, name: str, least: int, most: int) -> int:
        """Return a hexadecimal number, with or without 0x."""
        value = self.text(name)
        digits = value.lower().removeprefix("0x")
        if not re.fullmatch(r"[0-9a-f]{1,16}", digits):
            self.fault(
                name, self._word("base.no-hex", value=value[:40], least=f"{least:X}", most=f"{most:X}")
            )
            return least
        return self._within(name, int(digits, 16), least, most, "{:X}".format)

    def _within(self, name: str, number: int, least: int, most: int, shown: Callable[[int], str]) -> int:
        if least <= number <= most:
            return number
        self.fault(
            name,
            self._word("base.out-of-range", value=shown(number), least=shown(least), most=shown(most)),
        )
        return least
