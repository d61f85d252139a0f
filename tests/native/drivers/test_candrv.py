"""CANDRV in C: the manual's listings as printed, its examples, and what goes wrong."""

from __future__ import annotations

import pytest

from tests.native.drivers.conftest import PROGRAMS, Build, Machine


@pytest.mark.conforms("N-41", "N-45")
def test_the_manuals_examples_and_every_mistake(build: Build, machine: Machine) -> None:
    assert "did what it says" in machine.run(build(PROGRAMS / "candrv.c", "candrv"))
