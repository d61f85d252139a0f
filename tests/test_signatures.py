"""What the door's signatures promise: types that the door has, units in names, and values that show their state."""

from __future__ import annotations

import builtins
import collections.abc
import importlib
import inspect
import os
import sys
import typing
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple, is_typeddict

import numpy
import pytest

import canwire
from canwire import BitLayout, Frame, HubChannel, Lab, NodeScript
from tests.cases import each
from tests.uncompiled import load_uncompiled

pytestmark = pytest.mark.finding("newcomer F11")

# For the floors below and beside the door (docs/architecture.md, "Seams"): methods that users have no use for, and
# what they speak in. They keep plain names because other files call them.
SEAMS = {
    "CanBenchNode.begin", "Client.adopt", "Client.ask", "Client.call", "Client.forget",
    "Client.lent", "Event.signals", "RingEnd.lend",
    "ClientTime.ask", "ClientTime.call", "ClientTime.keep_time", "ClientTime.keeper",
    "Lab.company", "Lab.kick", "LabTime.keeper", "LabTime.kick", "Event.bind",
    "Event.unbind", "BenchBus.forget", "LabBus.stalled", "LabFaults.islands", "LabTime.active", "LabTime.advance",
    "LabTime.check_open", "LabTime.touch", "LabTime.turn", "Lease.ask", "LinBenchNode.set_up",
    "LinDisturber.header", "LinDisturber.response", "LinFaults.header", "LinFaults.response",
    "NodeScript.run_on",
}  # fmt: skip
SEAM_FIELDS = {"LinFault.in_header", "LinFault.in_response"}
FRACTIONS_OF_A_NANOSECOND = {  # what hardware takes, and where in a bit a glitch is: no moments on a timeline
    "BitTiming.search(propagation_delay_ns)", "Lab.can_bus(node_delay_ns)", "Forcing.glitch(from_ns)",
    "Forcing.glitch(width_ns)", "CanBusFaults.glitch(from_ns)", "CanBusFaults.glitch(width_ns)",
    "CanBusFaults.cable(node_delay_ns)",
}  # fmt: skip
# parameters and fields of these types are given by the class that users see
BASES = {"CanBenchNode": "LabNode", "LinBenchNode": "LabLinNode"}
HERE_FOR_TESTS_BELOW = {"Node"}  # a fault's victim may be a controller where there is no lab

SECONDS = {"timeout", "within", "seconds", "every", "after", "sleep_after", "start_up", "patience_s"}
UNITS = ("_s", "_m", "_ppm", "_rate", "_percent", "_hz")


class Signature(NamedTuple):
    """A public function or method, where it stands, and what its annotations mean."""

    name: str
    function: Callable[..., Any]
    hints: dict[str, Any]


def door() -> dict[str, Any]:
    return {name: getattr(canwire, name) for name in canwire.__all__}


def signatures() -> Iterator[Signature]:
    """Every public function, and every public method of a public class or of what it is made from."""
    for name, value in door().items():
        if isinstance(value, type):
            for kind in value.__mro__:
                if kind.__module__.startswith("canwire"):
                    yield from methods(kind)
        elif callable(value):
            yield Signature(name, value, meaning(value))


def methods(kind: type) -> Iterator[Signature]:
    for name, value in vars(kind).items():
        inner = getattr(value, "fget", None) or getattr(value, "__func__", value)
        if not name.startswith("_") and hasattr(inner, "__annotations__") and not isinstance(inner, type):
            yield Signature(f"{kind.__name__}.{name}", inner, meaning(inner))


def meaning(function: Callable[..., Any]) -> dict[str, Any]:
    """Annotations as types; what a file imports for type checkers alone is found in the door or where it stands."""
    known = {**vars(typing), **vars(collections.abc), "os": os, "numpy": numpy, **door()}
    known |= vars(sys.modules[function.__module__])
    known["Company"] = canwire.threads.company.Company  # type: ignore[attr-defined]
    known["Keeper"] = canwire.threads.keeper.Keeper  # type: ignore[attr-defined]
    known["Answer"] = canwire.hub.protocol.link.Answer  # type: ignore[attr-defined]
    return {name: eval(text, known) if isinstance(text, str) else text
            for name, text in function.__annotations__.items()}  # fmt: skip


def types_in(hint: Any) -> Iterator[type]:
    if isinstance(hint, list):
        for part in hint:
            yield from types_in(part)
    elif typing.get_args(hint):
        for part in typing.get_args(hint):
            yield from types_in(part)
    elif isinstance(hint, type):
        yield hint


@pytest.fixture(scope="module")
def everything() -> list[Signature]:
    importlib.import_module("canwire.hub.protocol.link")
    importlib.import_module("canwire.threads.company")
    found = list(signatures())
    assert len(found) > 300
    return found


def test_the_door_has_every_type_that_a_signature_names(everything: list[Signature]) -> None:
    there = {id(value) for value in door().values()}
    missing = {
        f"{kind.__name__} of {one.name}"
        for one in everything
        if one.name not in SEAMS
        for hint in one.hints.values()
        for kind in types_in(hint)
        if kind.__module__.startswith("canwire")
        and id(kind) not in there
        and kind.__name__ not in {*BASES, *HERE_FOR_TESTS_BELOW}
    }
    assert missing == set()


def test_seams_are_written_down_and_there(everything: list[Signature]) -> None:
    assert {one.name for one in everything} >= SEAMS
    page = (canwire_root() / "docs" / "architecture.md").read_text(encoding="utf-8")
    assert [name for name in sorted(SEAMS) if f"`{name}`" not in page] == []


def test_fields_of_public_values_are_types_of_the_door() -> None:
    there = {id(value) for value in door().values()}
    missing = {
        f"{kind.__name__} of {value.__name__}.{name}"
        for value in door().values()
        if isinstance(value, type) and value.__module__.startswith("canwire")
        for name, text in vars(value).get("__annotations__", {}).items()
        if not name.startswith("_")
        and isinstance(text, str)
        and f"{value.__name__}.{name}" not in SEAM_FIELDS
        for kind in types_in(eval(text, names_in(value.__module__)))
        if kind.__module__.startswith("canwire")
        and id(kind) not in there
        and kind.__name__ not in {*BASES, *HERE_FOR_TESTS_BELOW}
    }
    assert missing == set()


def names_in(module: str) -> dict[str, Any]:
    """What annotations of a file may name, what it imports for types alone as well."""
    numpy = importlib.import_module("numpy")
    return {**vars(typing), "numpy": numpy, **vars(sys.modules[module]), **door()}


def test_nanoseconds_are_whole_and_say_so(everything: list[Signature]) -> None:
    wrong = [
        f"{one.name}({name})"
        for one in everything
        for name, hint in one.hints.items()
        if name.endswith("_ns") and set(types_in(hint)) - {type(None)} != {int}
    ]
    wrong = [name for name in wrong if name not in FRACTIONS_OF_A_NANOSECOND]
    assert wrong == []


def test_times_that_are_floats_are_seconds(everything: list[Signature]) -> None:
    wrong = []
    for one in everything:
        for name, hint in one.hints.items():
            if name == "return" or float not in set(types_in(hint)) or name.endswith(UNITS):
                continue
            text = inspect.getdoc(one.function) or ""
            if name in SECONDS and "second" not in text + name:
                wrong.append(f"{one.name}({name}) does not say that it is in seconds")
    assert wrong == []


def canwire_root() -> Any:
    from pathlib import Path

    return Path(__file__).parent.parent


def test_every_public_class_shows_its_state() -> None:
    """Errors and protocols have a text of their own, or nothing to show."""
    plain = [
        name
        for name, value in door().items()
        if isinstance(value, type)
        and value.__repr__ is builtins.object.__repr__
        and not getattr(value, "_is_protocol", False)
    ]
    assert plain == []


class Thermometer(NodeScript):
    """Does nothing yet."""


def test_the_bench_shows_its_state() -> None:
    script = Thermometer()
    assert repr(script) == "<Thermometer on no node yet>"
    with Lab() as lab:
        assert repr(lab) == "<lab in virtual time, 0 ns: no bus>"
        bus = lab.can_bus(data_bit_rate=2_000_000)
        lin = lab.lin_bus()
        lin.master()
        a, b = bus.node("a", script), bus.node("b")
        a.send(Frame(1))
        timer = lab.at(5, lambda: None)
        periodic = script.every(1.0)
        shown = [repr(one) for one in (bus, lin, a, script, bus.faults, lin.faults, timer, periodic)]
        assert shown == [
            "<CAN bus can0, 500000 bit/s, 2000000 after BRS: a, b; 0 frames, 0 error frames>",
            "<LIN bus lin0, 19200 bit/s: master; 0 frames>",
            "<node can0/a: ERROR_ACTIVE, TEC 0, REC 0>",
            "<Thermometer on can0/a>",
            "<faults of a CAN bus: 0 scripted, bit error rate 0>",
            "<faults of a LIN bus: 0 scripted>",
            "<timer at 5 ns>",
            "<every 1000000000 ns, next at 1000000000 ns>",
        ]
        bus.faults.flip(bit=20)
        periodic.cancel()
        lab.run_until_idle()
        assert repr(bus.faults) == "<faults of a CAN bus: 0 scripted, bit error rate 0>"
        assert repr(timer) == "<timer at 5 ns, cancelled or over>"
        assert repr(periodic) == "<every 1000000000 ns, cancelled>"
        assert "1 frames, 1 error frames" in repr(bus)
        assert b.receive() == Frame(1)
    assert repr(lab) == "<lab in virtual time, closed: can0, lin0>"


def test_a_hub_s_handles_show_their_state() -> None:
    with canwire.connect(time="virtual") as hub:
        channel = hub.open_channel(hub.boards()[0].id, 0)
        assert isinstance(channel, HubChannel)
        assert repr(channel) == "<channel on line 0, not set up>"
        channel.set_up(canwire.ChannelMode(receive=16, transmit=4))
        assert repr(channel) == "<channel on line 0, 0 of 16 received, 0 of 4 to send>"
        channel.send(Frame(1))
        assert repr(channel) == "<channel on line 0, 0 of 16 received, 1 of 4 to send>"
        assert repr(channel.writing) == "<end of channel on line 0's queue: 1 of 4 to send>"
        assert repr(channel.writing.ring) == "<ring, 1 of 4 records of 80 bytes>"
        channel.close()
        assert repr(channel) == "<channel on line 0, closed>"
    event = canwire.Event()
    event.set()
    assert repr(event) == "<auto-reset event, signalled, 0 assigned>"
    event.close()
    assert repr(event) == "<auto-reset event, closed>"


def test_values_of_the_core_show_theirs() -> None:
    assert repr(BitLayout(Frame(0))) == "<50 bits on the wire, 6 of them stuff bits, CRC 0x0>"
    reader = canwire.SlcanReader()
    reader.feed(b"t12")
    assert repr(reader) == "<slcan reader, 3 bytes of an unfinished line, 0 dropped>"


@pytest.mark.conforms("N-20")
def test_compiled_classes_tell_how_they_are_called() -> None:
    with load_uncompiled(canwire) as twin:
        for name in ("BitLayout", "SlcanReader", "Ring"):
            declared = list(inspect.signature(getattr(twin, name).__init__).parameters.values())[1:]
            assert list(inspect.signature(getattr(canwire, name)).parameters.values()) == declared
    silent = []
    for name, value in door().items():
        if isinstance(value, type) and not (is_typeddict(value) or issubclass(value, (Exception, int))):
            try:
                inspect.signature(value)
            except ValueError:
                silent.append(name)
    assert set(silent) <= {"Timer"}  # Lab.at makes these; compiled it tells nothing


@pytest.mark.conforms("N-20")
def test_both_forms_explain_and_call_the_same() -> None:
    """`help` and `inspect.signature` of every class of the door and its methods, compiled and interpreted."""
    compiled = {name: _explained(value) for name, value in door().items() if isinstance(value, type)}
    with load_uncompiled(canwire) as twin:
        for name, here in compiled.items():
            there = _explained(getattr(twin, name))
            assert {one: told for one, told in there.items() if one in here} == {
                one: told for one, told in here.items() if one in there
            }, name


def _explained(kind: type) -> dict[str, tuple[str | None, list[str]]]:
    """Help and parameters of a class and of its public methods."""
    methods = {one: getattr(kind, one) for one in dir(kind) if not one.startswith("_")}
    found = {
        one: (inspect.getdoc(each), _parameters(each)) for one, each in methods.items() if callable(each)
    }
    return found | {"": (inspect.getdoc(kind), [])}


def _parameters(function: Any) -> list[str]:
    """Their names; none of what is no function, or does not tell."""
    try:
        return list(inspect.signature(function).parameters)
    except (TypeError, ValueError):
        return []


@pytest.mark.conforms("N-20")
@each(
    "expression",
    [
        "Frame(0x123, b'ab', extended=True)",
        "BitLayout(Frame(0))",
        "SlcanReader()",
        "Acceptance.everything()",
        "Counters(8, 1, ErrorState.ERROR_ACTIVE, 2, 3, 4, 5)",
        "BusEvent(EventKind.ERROR, error=ErrorKind.CRC)",
    ],
)
def test_both_forms_show_themselves_alike(expression: str) -> None:
    """`repr` and `dir`."""
    here = eval(expression, door())
    with load_uncompiled(canwire) as twin:
        there = eval(expression, {name: getattr(twin, name) for name in twin.__all__})
        assert repr(here) == repr(there)
        assert [one for one in dir(here) if one[0] != "_"] == [one for one in dir(there) if one[0] != "_"]
