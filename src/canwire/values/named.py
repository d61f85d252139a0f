"""Numbers that print their names: `print(node.state)` shows ERROR_ACTIVE, which still is 0 where a number is wanted."""

from __future__ import annotations

from enum import IntEnum, IntFlag


class NamedInt(IntEnum):
    """An IntEnum that str() and format() show by its name; format codes for numbers (d, x, b) show the number."""

    def __str__(self) -> str:
        return self.name

    def __format__(self, spec: str) -> str:
        return _formatted(self, spec)


class NamedFlags(IntFlag):
    """The same for flags: A|B; what has no name stays a number, and none at all is 0."""

    def __str__(self) -> str:
        return self.name or str(int(self))

    def __format__(self, spec: str) -> str:
        return _formatted(self, spec)


def _formatted(value: NamedInt | NamedFlags, spec: str) -> str:
    return format(int(value) if spec[-1:] in tuple("bcdeEfFgGnoxX%") else str(value), spec)
