"""Everything that is tried with one class or function: each try has a name, and can be repeated by its number."""

from __future__ import annotations

import gc
import inspect
import random
import threading
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

from tests.walk.names import WAITS, classes_of, functions_of, loaded
from tests.walk.values import CallsBack, plain

_MOST_ARGUMENTS = 9
# of Python itself, for objects of any class; `__del__` is for the collector
_PYTHONS = {"__class__", "__dict__", "__doc__", "__module__", "__weakref__", "__del__", "__subclasshook__",
            "__init_subclass__", "__class_getitem__", "__getstate__", "__sizeof__", "__dir__", "__format__",
            "__annotations__", "__slots__", "__abstractmethods__", "__parameters__", "__orig_bases__"}  # fmt: skip


class Attempt(NamedTuple):
    """`call` does it; whatever it raises is for the caller to judge."""

    name: str
    call: Callable[[], object]


class Subjects:
    """One module's attempts. `healthy` has things in the middle of their work by their class."""

    def __init__(self, module: str, healthy: dict[type, Any], seed: int) -> None:
        self.module = loaded(module)
        self.healthy = healthy
        self.random = random.Random(f"{module} {seed}")
        kinds = [*classes_of(self.module), *healthy]
        self.raw = [thing for kind in kinds if (thing := never_initialised(kind)) is not None]

    def systematic(self) -> Iterator[Attempt]:
        """Each name with nothing, None, a number, a thing never initialised, and what calls back."""
        for name, function in functions_of(self.module):
            yield from self._called(
                f"{self.module.__name__}.{name}", function, CallsBack(partial(gc.collect, 0)), full=True
            )
        for kind in classes_of(self.module):
            name = f"{self.module.__name__}.{kind.__name__}"
            yield from self._called(name, kind, CallsBack(partial(gc.collect, 0)), full=True)
            for state, make in self._states(kind):
                for attribute in attributes(kind):
                    yield from self._used(f"{name}.{attribute} {state}", make, attribute)

    def at_random(self) -> Iterator[Attempt]:
        """Without an end: any name, any values, now and then in two threads."""
        places = [
            (kind, state, make) for kind in classes_of(self.module) for state, make in self._states(kind)
        ]
        functions = list(functions_of(self.module))
        while places or functions:
            if functions and (not places or self.random.random() < 0.1):
                name, function = self.random.choice(functions)
                yield self._random_call(
                    f"{self.module.__name__}.{name}", function, CallsBack(partial(gc.collect, 0))
                )
                continue
            kind, state, make = self.random.choice(places)
            attribute = self.random.choice(attributes(kind))
            name = f"{self.module.__name__}.{kind.__name__}.{attribute} {state}"
            thing = make()
            if thing is None or waits(name):
                continue
            yield self._random_use(name, thing, attribute)

    # one name

    def _states(self, kind: type) -> list[tuple[str, Callable[[], Any]]]:
        states = [("never initialised", partial(never_initialised, kind))]
        if kind in self.healthy:
            states.append(("at work", lambda: self.healthy[kind]))
        return states

    def _used(self, name: str, make: Callable[[], Any], attribute: str) -> Iterator[Attempt]:
        thing = make()
        if thing is None or waits(name):
            return
        yield Attempt(f"{name}: read", lambda: getattr(thing, attribute))
        member = member_of(thing, attribute)
        if callable(member):
            again = CallsBack(partial(_all_of, thing))
            yield from self._called(name, member, again, full=False)
        elif not attribute.startswith("__"):
            for value in (None, -1, 2**70, b"", self.raw[0] if self.raw else None):
                yield Attempt(f"{name} = {short(value)}", partial(setattr, make(), attribute, value))
            yield Attempt(f"del {name}", partial(delattr, make(), attribute))

    def _called(
        self, name: str, function: Callable[..., Any], again: CallsBack, *, full: bool
    ) -> Iterator[Attempt]:
        if waits(name):
            return
        sames = [
            None,
            -1,
            2**63 - 1,
            2**70,
            1.5,
            b"",
            b"\xff" * 80,
            [],
            "x",
            again,
            *self.raw[: 9 if full else 3],
        ]
        for count in arities(function):
            for value in sames[: len(sames) if count else 1]:
                values = [value] * count
                yield Attempt(f"{name}({', '.join(map(short, values))})", partial(function, *values))

    def _random_call(self, name: str, function: Callable[..., Any], again: CallsBack) -> Attempt:
        pool = [*plain(), *self.raw, *self.healthy.values(), again, again, again]
        values = [self.random.choice(pool) for _ in range(self.random.choice(arities(function)))]
        text = f"{name}({', '.join(map(short, values))})"
        if self.random.random() < 0.02:
            return Attempt(f"{text} in two threads", partial(_beside_itself, partial(function, *values)))
        return Attempt(text, partial(function, *values))

    def _random_use(self, name: str, thing: Any, attribute: str) -> Attempt:
        member = member_of(thing, attribute)
        if callable(member):
            return self._random_call(name, member, CallsBack(partial(_all_of, thing)))
        if self.random.random() < 0.3:
            value = self.random.choice([*plain(), *self.raw, *self.healthy.values()])
            return Attempt(f"{name} = {short(value)}", partial(setattr, thing, attribute, value))
        return Attempt(f"{name}: read", partial(getattr, thing, attribute))


def never_initialised(kind: type) -> Any:
    """`kind.__new__(kind)`, None where the class does not let that be."""
    try:
        return kind.__new__(kind)
    except Exception:
        return None


def member_of(thing: Any, attribute: str) -> Any:
    """None where reading it raises anything: a property may."""
    try:
        return getattr(thing, attribute)
    except Exception:
        return None


def attributes(kind: type) -> list[str]:
    """All names of its objects, but Python's own for any object."""
    return [name for name in dir(kind) if name not in _PYTHONS]


def waits(name: str) -> bool:
    """It waits without a limit, as it says."""
    return name.partition(" ")[0].partition("(")[0] in WAITS


def arities(function: Callable[..., Any]) -> list[int]:
    """How many arguments it takes by their places; a guess where it does not say."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (ValueError, TypeError):
        return list(range(7))
    by_place = [
        each for each in parameters if each.kind in (each.POSITIONAL_ONLY, each.POSITIONAL_OR_KEYWORD)
    ]
    if any(each.kind == each.VAR_POSITIONAL for each in parameters):
        return list(range(7))
    needed = sum(each.default is each.empty for each in by_place)
    return list(range(needed, min(len(by_place), _MOST_ARGUMENTS) + 1))


def short(value: object) -> str:
    """A value's name in a row; never its own `repr`, which may be what fails."""
    if isinstance(value, (int, float, str, bytes, type(None), list, tuple)):
        text = repr(value)
        return text if len(text) < 30 else f"{text[:26]}..."
    return f"<{type(value).__qualname__}>"


def _all_of(thing: Any) -> None:
    """Use a thing in its own call: each method without an argument, and its attributes taken away."""
    for name in attributes(type(thing)):
        if name.startswith("__") or waits(f"{type(thing).__module__}.{type(thing).__name__}.{name}"):
            continue
        try:
            member = getattr(thing, name)
            if callable(member):
                member()
            else:
                delattr(thing, name)
        except Exception:  # what it answers is looked at where it is called by itself
            continue


def _beside_itself(call: Callable[[], object]) -> None:
    def often() -> None:
        for _ in range(20):
            try:
                call()
            except Exception:  # as above
                continue

    threads = [threading.Thread(target=often) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
