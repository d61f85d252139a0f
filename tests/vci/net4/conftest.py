"""Programs that use VCI under the names of Ixxat.Vci4, on the hubs of tests/vci/conftest.py."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import pytest

import canwire
from canwire import vci
from tests.vci.net4.programs import Net4
from tests.vci.programs import Virtual


@pytest.fixture
def net4(hub: canwire.Hub) -> Iterator[Net4]:
    """A program on any kind of hub."""
    with contextlib.closing(Net4(hub)) as made:
        yield made


@pytest.fixture
def virtual4(virtual: Virtual) -> Iterator[Net4]:
    """A program on a hub in virtual time, which stands still while nobody waits."""
    vci.initialize(virtual.hub)
    with contextlib.closing(Net4(virtual.hub)) as made:
        yield made
