"""Frozen dataclasses that are quick to define, for what every program loads before its first frame.

The standard library compiles six methods for each class; this module compiles only `__init__`, at its first call, and
shares the other methods. The classes work like dataclasses with `dataclasses.replace`, `fields` and `asdict`,
msgspec, pickle, `copy`, `match` and type checkers, since the attributes that `dataclasses` keeps in a class are made
at their first use. Annotations have to be strings (`from __future__ import annotations`); every class has
fields, no base with fields, and plain defaults.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:

    def dataclass(*, frozen: Literal[True], slots: Literal[True]) -> Callable[[type], type]:
        """The standard library's, of this one kind."""
        return _made


def _made(cls: type) -> type:
    kinds = cls.__annotations__
    names = tuple(name for name in kinds if not kinds[name].startswith("ClassVar"))
    space = {name: kept for name, kept in vars(cls).items() if name not in ("__dict__", "__weakref__")}
    defaults = {name: space.pop(name) for name in names if name in space}
    space = _METHODS | space | {"__slots__": names, "__match_args__": names, "_values": attrgetter(*names)}
    space["__init__"] = _Later(partial(_initialiser, names=names, defaults=defaults))
    for name, options in _ASKED_FOR.items():
        space[name] = _Later(partial(_twins, name=name, defaults=defaults, options=options))
    made = type(cls)(cls.__name__, cls.__bases__, space)
    made.__qualname__ = cls.__qualname__
    return made


class _Later:
    """An attribute of a class that is made at its first use, and then replaces this object."""

    def __init__(self, make: Callable[[type], Any]) -> None:
        self._make = make

    def __set_name__(self, owner: type, name: str) -> None:
        self._owner, self._name = owner, name

    def __get__(self, instance: object, owner: type) -> Any:
        setattr(self._owner, self._name, self._make(self._owner))
        return getattr(owner if instance is None else instance, self._name)


def _initialiser(cls: type, names: tuple[str, ...], defaults: dict[str, Any]) -> Any:
    words = [f"{name}=_defaults[{name!r}]" if name in defaults else name for name in names]
    lines = [f"  _set(self, {name!r}, {name})" for name in names]
    if hasattr(cls, "__post_init__"):
        lines.append("  self.__post_init__()")
    text = f"def _outer(_set, _defaults):\n def __init__(self, {', '.join(words)}):\n"
    space: dict[str, Any] = {}
    exec(f"{text}{chr(10).join(lines)}\n return __init__", sys.modules[cls.__module__].__dict__, space)
    found = space["_outer"](object.__setattr__, defaults)
    found.__qualname__ = f"{cls.__qualname__}.__init__"
    found.__annotations__ = {name: cls.__annotations__[name] for name in names} | {"return": None}
    from canwire.values.mistakes.calls import EXAMPLES, answers_wrong_calls

    return answers_wrong_calls(found, cls.__name__, "__init__") if cls.__name__ in EXAMPLES else found


def _repr(self: Any) -> str:
    shown = ", ".join(f"{name}={getattr(self, name)!r}" for name in self.__match_args__)
    return f"{self.__class__.__qualname__}({shown})"


def _equal(self: Any, other: Any) -> bool:
    if other.__class__ is not self.__class__:
        return NotImplemented
    return bool(self._values(self) == other._values(other))


def _hash(self: Any) -> int:
    return hash(self._values(self))


def _set(self: Any, name: str, value: object) -> None:
    _refuse(self, name, "assign to")
    object.__setattr__(self, name, value)


def _delete(self: Any, name: str) -> None:
    _refuse(self, name, "delete")
    object.__delattr__(self, name)


def _refuse(self: Any, name: str, what: str) -> None:
    """Refuse fields, and any attribute of the class itself; subclasses may add attributes."""
    if name in self.__match_args__ or "__match_args__" in vars(type(self)):
        from dataclasses import FrozenInstanceError

        raise FrozenInstanceError(f"cannot {what} field {name!r}")


def _state(self: Any) -> list[Any]:
    return [getattr(self, name) for name in self.__match_args__]


def _take_state(self: Any, state: list[Any]) -> None:
    for name, value in zip(self.__match_args__, state, strict=True):
        object.__setattr__(self, name, value)


def _replaced(self: Any, /, **changes: Any) -> Any:
    from dataclasses import replace

    return replace(self, **changes)


_METHODS: dict[str, Any] = {
    "__repr__": _repr,
    "__eq__": _equal,
    "__hash__": _hash,
    "__setattr__": _set,
    "__delattr__": _delete,
    "__getstate__": _state,
    "__setstate__": _take_state,
    "__replace__": _replaced,
}
_ASKED_FOR: dict[str, dict[str, bool]] = {
    "__dataclass_fields__": {"init": False, "repr": False, "eq": False},
    "__dataclass_params__": {"frozen": True},
}
"""What marks a dataclass, and the options with which `dataclasses` makes just that."""


def _twins(cls: type, name: str, defaults: dict[str, Any], options: dict[str, bool]) -> Any:
    """The functions that `dataclasses` generates under this attribute for a class with these fields."""
    from dataclasses import dataclass

    like = {"__module__": cls.__module__, "__doc__": "_", "__annotations__": cls.__annotations__}
    return getattr(dataclass(**options)(type(cls.__name__, (), like | defaults)), name)
