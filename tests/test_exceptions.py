"""Every exception of the package, public or not, comes out of pickle and copies as it went in."""

from __future__ import annotations

import copy
import importlib
import inspect
import pickle
import pkgutil
import sys
from collections.abc import Callable, Iterator
from typing import Any

import pytest

import canwire
from canwire import CanwireError, Frame
from canwire.hub.protocol.failure import raised
from canwire.hub.protocol.messages import Failed
from tests.cases import each

MADE_UP: dict[str, Any] = {
    "str": "made up",
    "int": 87,
    "object": Frame(0x123, b"\x11"),
    "Mapping[str, str]": {"Speed": "300 is too fast", "Gear": "9 is no gear"},
}
"""A value for each kind of field that exceptions have."""
OF_TOOLS = (
    "starlette",
    "uvicorn",
    "jinja2",
    "canopen",
    "udsoncan",
    "isotp",
    "j1939",
    "can",
    "pytest",
    "numpy",
)
"""Optional packages, without which some modules cannot be imported."""

FOR_C = ("canwire.native.lib.", "canwire.socketcan._shim")
"""Libraries that are no modules of Python."""


def modules() -> Iterator[str]:
    for found in pkgutil.walk_packages(canwire.__path__, "canwire."):
        if not found.name.startswith(FOR_C) and not found.name.endswith("__main__"):
            yield found.name


def load_everything() -> None:
    for name in modules():
        try:
            importlib.import_module(name)
        except ImportError as error:
            if (error.name or "").partition(".")[0] not in OF_TOOLS:
                raise


def below(kind: type[BaseException]) -> Iterator[type[BaseException]]:
    for one in kind.__subclasses__():
        yield one
        yield from below(one)


def exceptions() -> list[type[BaseException]]:
    load_everything()
    ours = {
        kind
        for kind in below(BaseException)
        if kind.__module__.startswith("canwire.")
        and getattr(sys.modules.get(kind.__module__), kind.__qualname__, None) is kind
    }  # others are those of modules that a test has loaded anew
    return sorted(ours, key=lambda kind: (kind.__module__, kind.__qualname__))


def made(kind: type[BaseException]) -> BaseException:
    """An exception with made-up fields: what its own `__init__` asks for, or a text."""
    if kind.__init__ in (each.__init__ for each in kind.__mro__ if each.__module__ == "builtins"):
        return kind("made up, at byte 17")
    fields = inspect.signature(kind.__init__).parameters.values()
    return kind(*(MADE_UP[field.annotation] for field in fields if field.name != "self"))


def by_pickle(protocol: int) -> Callable[[BaseException], Any]:
    return lambda error: pickle.loads(pickle.dumps(error, protocol))


WAYS = [*map(by_pickle, range(pickle.HIGHEST_PROTOCOL + 1)), copy.copy, copy.deepcopy]


def same(error: BaseException, again: BaseException) -> bool:
    return (type(again), str(again), repr(again), again.args, vars(again)) == (
        type(error),
        str(error),
        repr(error),
        error.args,
        vars(error),
    )


@pytest.mark.finding("faults-2 3")
def test_every_exception_travels_with_its_fields_and_its_text() -> None:
    kinds = exceptions()
    assert len(kinds) > 60
    failed = []
    for kind in kinds:
        error = made(kind)
        error.add_note("while it was tried")
        for way in WAYS:
            try:
                assert same(error, way(error))
            except Exception as why:
                failed.append(f"{kind.__module__}.{kind.__qualname__}: {type(why).__name__}: {why}")
                break
    assert not failed, "\n".join(failed)


@each("name", ["QueueFull", "BadSignals", "ExtraMissing", "NoSuchBoard"])
def test_an_error_of_the_hub_travels_on(name: str) -> None:
    """It came as a text, and has no fields."""
    error = raised(Failed(name, "can0: what the hub said"))
    for way in WAYS:
        assert same(error, way(error))


def test_a_programs_own_error_travels() -> None:
    error = _OfAProgram("can0", 3)
    for way in WAYS:
        assert same(error, way(error))
        assert way(error).attempts == 3


def test_what_is_missing_is_told_to_importers() -> None:
    """ImportError's own `msg` is there, as before the journey."""
    error = pickle.loads(pickle.dumps(canwire.ExtraMissing("pyarrow", "parquet")))
    assert isinstance(error, ImportError)
    assert (error.msg, error.module, error.extra) == (str(error), "pyarrow", "parquet")


class _OfAProgram(CanwireError):
    def __init__(self, line: str, attempts: int) -> None:
        super().__init__(f"{line}: {attempts} attempts")
        self.attempts = attempts
