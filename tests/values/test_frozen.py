"""Our frozen dataclasses beside the standard library's: nobody can tell them apart."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import pickle
import types
import typing
from typing import Any, ClassVar

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

import canwire
from canwire.errors import BadValue
from canwire.values import frozen
from tests.cases import each

OURS = [
    canwire.BitTiming, canwire.BoardInfo, canwire.BusEvent, canwire.Capabilities, canwire.ChannelMode,
    canwire.ChannelStatus, canwire.ControllerOptions, canwire.CyclicStatus, canwire.DelayCompensation,
    canwire.FilterContent, canwire.FilterSetup, canwire.LinCapabilities, canwire.LineInfo, canwire.LineMode,
    canwire.LineStatus, canwire.RegisterValue, canwire.Ticks, canwire.TimedProgram, canwire.TimingLimits,
    canwire.TimingRange, canwire.WantedMode,
]  # fmt: skip


class _Point:
    """A place."""

    x: int
    y: tuple[int, ...] = (1, 2)
    name: str = "here"
    LARGEST: ClassVar[int] = 1000

    def __post_init__(self) -> None:
        if self.x > self.LARGEST:
            raise BadValue(f"x {self.x}: {self.LARGEST} at most")

    @property
    def doubled(self) -> int:
        return 2 * self.x


def _as(make: Any, name: str) -> Any:
    made = make(frozen=True, slots=True)(type(name, (), dict(vars(_Point))))
    made.__qualname__ = name
    return made


Ours, Theirs = _as(frozen.dataclass, "Ours"), _as(dataclasses.dataclass, "Theirs")
POINTS = st.fixed_dictionaries(
    {"x": st.integers(-5, 1000)},
    optional={"y": st.lists(st.integers(0, 3), max_size=2).map(tuple), "name": st.sampled_from("ab")},
)


@given(one=POINTS, other=POINTS)
def test_both_kinds_agree(one: dict[str, Any], other: dict[str, Any]) -> None:
    (a, b), (c, d) = [(kind(**one), kind(**other)) for kind in (Ours, Theirs)]
    assert repr(a).replace("Ours", "Theirs") == repr(c)
    assert ((a == b), (a != b)) == ((c == d), (c != d))
    assert (hash(a) == hash(b)) or a != b
    assert dataclasses.asdict(a) == dataclasses.asdict(c)
    assert dataclasses.asdict(dataclasses.replace(a, **other)) == dataclasses.asdict(
        dataclasses.replace(c, **other)
    )
    assert a != c
    assert a.doubled == c.doubled
    assert [pickle.loads(pickle.dumps(a)), copy.copy(a), copy.deepcopy(a), a.__replace__()] == [a] * 4
    assert msgspec.json.encode(a) == msgspec.json.encode(c)
    assert msgspec.json.decode(msgspec.json.encode(a), type=Ours) == a


@pytest.mark.parametrize("kind", [Ours, Theirs])
def test_what_is_refused(kind: Any) -> None:
    point = kind(1)
    for forbidden in (
        lambda: setattr(point, "x", 2),
        lambda: delattr(point, "x"),
        lambda: setattr(point, "z", 2),
    ):
        with pytest.raises((dataclasses.FrozenInstanceError, TypeError)):
            forbidden()
    for wrong in ((), (1, 2, 3, 4)):
        with pytest.raises(TypeError, match=r"__init__\(\)"):
            kind(*wrong)
    with pytest.raises(TypeError, match="unexpected keyword argument 'z'"):
        kind(1, z=2)
    with pytest.raises(BadValue, match="1000 at most"):
        kind(1001)
    with pytest.raises(msgspec.ValidationError):
        msgspec.json.decode(b'{"x": "1"}', type=kind)
    assert point == kind(1)
    assert (point == 1) is False


def test_classes_that_extend_one() -> None:
    class Named(Ours):  # type: ignore[misc]
        pass

    named = Named(1)
    named.remark = "of its own"
    with pytest.raises(dataclasses.FrozenInstanceError):
        named.x = 2
    assert (named.remark, named.x, named == Ours(1)) == ("of its own", 1, False)

    @dataclasses.dataclass(frozen=True)
    class Wider(Ours):  # type: ignore[misc]
        z: int = 3

    assert dataclasses.asdict(Wider(1)) == {"x": 1, "y": (1, 2), "name": "here", "z": 3}


@each("kind", OURS, ids=lambda kind: kind.__name__)
def test_canwires_own_are_such(kind: Any) -> None:
    fields = dataclasses.fields(kind)
    defaults = {field.name: field.default for field in fields if field.default is not dataclasses.MISSING}
    like = {"__annotations__": kind.__annotations__, "__module__": kind.__module__} | defaults
    standard: Any = dataclasses.dataclass(frozen=True, slots=True)(type(kind.__name__, (), like))
    assert inspect.signature(kind) == inspect.signature(standard)
    assert [field.name for field in fields] == [field.name for field in dataclasses.fields(standard)]
    assert kind.__match_args__ == standard.__match_args__
    assert kind.__slots__ == standard.__slots__
    assert kind.__dataclass_params__.frozen
    assert {*typing.get_type_hints(kind)} >= {field.name for field in fields}
    assert kind.__setattr__ is Ours.__setattr__
    assert not hasattr(kind, "__dict__") or "__dict__" not in dir(kind)


def test_nothing_is_compiled_before_it_is_asked_for() -> None:
    made = _as(frozen.dataclass, "Made")
    late = ("__init__", "__dataclass_fields__", "__dataclass_params__")
    before = [vars(made)[name] for name in late]
    made(1)
    dataclasses.fields(made)
    kinds = [type(vars(made)[name]) for name in late]
    assert kinds[:2] == [types.FunctionType, dict]
    assert vars(made)["__dataclass_params__"] is before[2]
