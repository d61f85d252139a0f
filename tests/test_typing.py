"""Typed, self-contained, and at home for any user: what the package promises before it does anything."""

from __future__ import annotations

import inspect
import os
import subprocess
import sys
import textwrap
import typing
from collections.abc import Iterator
from pathlib import Path

import pytest

import canwire

HOME = Path(canwire.__file__).parents[1]

USE_THE_BUS = textwrap.dedent(
    """
    import sys
    before = set(sys.modules)
    import canwire
    with canwire.Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000, data_bit_rate=2_000_000)
        a, b = bus.node("engine"), bus.node("tester", filters=[(0x100, 0x700)])
        bus.faults.inject("crc")
        a.send(canwire.Frame(0x123, b"\\x11\\x22"))
        a.send(canwire.Frame(0x124, bytes(64), fd=True, bit_rate_switch=True))
        lab.run_until_idle()
        assert [frame.id for frame in b.receive_many(9)] == [0x123, 0x124]
    loaded = {name.partition(".")[0] for name in sys.modules.keys() - before}
    print(*sorted(loaded - set(sys.stdlib_module_names) - {"canwire"}))
    """
)


def run_isolated(program: str, **environment: str) -> str:
    """The program in a fresh interpreter that finds the standard library and canwire, and nothing else."""
    bootstrap = f"import sys; sys.path.insert(0, {str(HOME)!r})\n"
    only = {key: os.environ[key] for key in ("PATH", "SYSTEMROOT") if key in os.environ}
    done = subprocess.run(
        [sys.executable, "-I", "-S", "-B", "-c", bootstrap + program],
        capture_output=True,
        text=True,
        timeout=120,
        env=only | environment,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.conforms("PL-04")
def test_py_typed_is_shipped() -> None:
    assert (Path(canwire.__file__).parent / "py.typed").is_file()


@pytest.mark.conforms("PL-04")
def test_the_virtual_bus_needs_nothing_but_python() -> None:
    """Without site-packages at all; what is loaded besides the standard library is canwire's own.

    A compiled module makes up two modules in memory, for its runtime and the types it shares.
    """
    made_up = ("_cython_", "cython_runtime")
    assert [name for name in run_isolated(USE_THE_BUS).split() if not name.startswith(made_up)] == []


@pytest.mark.conforms("G-20")
def test_the_virtual_bus_runs_as_an_ordinary_user() -> None:
    """As nobody, who may open no device and write nowhere: no driver, no kernel module, no right is needed.

    On this machine; that other systems do the same, only a run there can show (G-20).
    """
    become_nobody = textwrap.dedent(
        """
        import contextlib, os
        if hasattr(os, "geteuid") and os.geteuid() == 0:
            with contextlib.suppress(OSError):
                os.setgroups([])
                os.setgid(65534)
            os.setuid(65534)
            assert os.geteuid() == os.getuid() == 65534
        """
    )
    run_isolated(USE_THE_BUS + become_nobody + USE_THE_BUS)


@pytest.mark.conforms("PL-04")
def test_importing_loads_neither_numpy_nor_cython() -> None:
    program = (
        "import sys, canwire; print(*[n for n in ('numpy', 'Cython', 'cython', 'can') if n in sys.modules])"
    )
    assert run_isolated(program).split() == []


def door() -> Iterator[tuple[str, object]]:
    """Every public function and method that the door leads to, by its name; inherited ones too."""
    for name in canwire.__all__:
        thing = getattr(canwire, name)
        if inspect.isclass(thing):
            members = {key: value for base in reversed(thing.__mro__) for key, value in vars(base).items()}
            for attribute, value in members.items():
                if isinstance(value, classmethod | staticmethod):
                    value = value.__func__
                if isinstance(value, property):
                    value = value.fget
                public = not attribute.startswith("_") or attribute == "__init__"
                if public and inspect.isfunction(value) and value.__module__.startswith("canwire"):
                    yield f"{name}.{attribute}", value
        elif inspect.isfunction(thing):
            yield name, thing


@pytest.mark.conforms("PL-04")
def test_every_public_function_is_annotated() -> None:
    assert {name: bare for name, function in door() if (bare := without_annotation(function))} == {}


def without_annotation(function: object) -> list[str]:
    """Of its parameters, and "return"."""
    signature = inspect.signature(function)  # type: ignore[arg-type]
    bare = [
        parameter.name
        for k, parameter in enumerate(signature.parameters.values())
        if parameter.annotation is parameter.empty and not (k == 0 and parameter.name in ("self", "cls"))
    ]
    generated = function.__qualname__.startswith("__create_fn__")  # type: ignore[attr-defined]
    if not generated and signature.return_annotation is signature.empty:
        bare.append("return")
    return bare


def test_the_door_has_functions_to_look_at() -> None:
    names = {name for name, _ in door()}
    assert {"Lab.can_bus", "LabBus.node", "LabNode.expect", "LabLinNode.receive"} <= names
    assert {"parse_frame", "NodeScript.every"} <= names


def test_errors_of_the_door_are_one_tree() -> None:
    errors = [
        value
        for name in canwire.__all__
        if isinstance(value := getattr(canwire, name), type) and issubclass(value, BaseException)
    ]
    assert all(issubclass(error, canwire.CanwireError) for error in errors)
    assert typing.get_type_hints(canwire.Closed.__init__)


def test_arrays_without_numpy_name_the_extra() -> None:
    program = textwrap.dedent(
        """
        sys.modules["numpy"] = None  # as if it were not installed
        import canwire
        with canwire.Lab() as lab:
            node = lab.can_bus().node("a")
            for call in (node.receive_array, canwire.record_dtype, lambda: canwire.frames_to_array([])):
                try:
                    call()
                except canwire.ExtraMissing as error:
                    print(error)
        """
    )
    said = run_isolated(program).splitlines()
    assert said == ["numpy is not installed; run: pip install 'canwire[arrays]'"] * 3
