"""A library that is missing is one line that says which, and what to install; those that are there work."""

from __future__ import annotations

import subprocess
import sys

import pytest

import canwire.ecus

PROGRAM = """
import sys
from importlib.machinery import PathFinder

class Hidden(PathFinder):
    @classmethod
    def find_spec(cls, name, path=None, target=None):
        return None if name.partition(".")[0] in {hidden!r} else super().find_spec(name, path, target)

sys.meta_path[:] = [each if each is not PathFinder else Hidden for each in sys.meta_path]
import canwire
try:
    print(canwire.ecus.{name}.__name__)
except canwire.ExtraMissing as error:
    print(error)
print(sorted({{"canopen", "isotp", "j1939", "udsoncan"}} & {{*sys.modules}}))
"""


@pytest.mark.parametrize(
    ("name", "hidden", "told"),
    [
        ("CanopenEcu", ("canopen",), "canopen is not installed"),
        ("LabJ1939", ("j1939",), "can-j1939 is not installed"),
        ("UdsEcu", ("udsoncan",), "udsoncan is not installed"),
        ("LabIsoTp", ("isotp",), "can-isotp is not installed"),
    ],
)
def test_what_is_missing_is_named(name: str, hidden: tuple[str, ...], told: str) -> None:
    program = PROGRAM.format(hidden=hidden, name=name)
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True
    )
    first, loaded = done.stdout.splitlines()
    assert (told in first, "canwire[protocols]" in first, loaded, done.stderr) == (True, True, "[]", "")


def test_others_are_not_needed() -> None:
    pytest.importorskip("isotp")
    program = PROGRAM.format(hidden=("canopen", "j1939", "udsoncan"), name="LabIsoTp")
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout == "LabIsoTp\n['isotp']\n"


def test_names() -> None:
    assert dir(canwire.ecus) == sorted(canwire.ecus.__all__)
    with pytest.raises(AttributeError, match=r"'canwire\.ecus' has no attribute 'Ecu'"):
        _ = canwire.ecus.Ecu
