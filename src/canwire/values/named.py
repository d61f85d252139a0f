"""Numbers that print their names: `print(node.state)` shows ERROR_ACTIVE, which is still the number 0."""

from __future__ import annotations

from enum import IntEnum, IntFlag


class NamedInt(IntEnum):
    """An IntEnum that str() and format() show by its name; format codes for numbers (d, x, b) show the number."""

    def __str__(self) -> str:
        return self.name

    def __format__(self, spec: str) -> str:
        return _formatted(self, spec)


class NamedFlags(IntFlag):
    """An IntFlag with the same formats: A|B; flags without a name are shown as a number, no flags as 0."""

    def __str__(self) -> str:
        return self.name or str(int(self))

    def __format__(self, spec: str) -> str:
        return _formatted(self, spec)


def _formatted(value: NamedInt | NamedFlags, spec: str) -> str:
    return format(int(value) if spec[-1:] in tuple("bcdeEfFgGnoxX%") else str(value), spec)
