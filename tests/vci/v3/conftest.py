"""Programs that use VCI under the names of V3, on the hubs of tests/vci/conftest.py."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

import pytest

import canwire
from canwire.vci import v3
from tests.hubs import Connect
from tests.vci.programs import Virtual
from tests.vci.v3.programs import NetProgram


@pytest.fixture
def net(hub: canwire.Hub) -> Iterator[NetProgram]:
    with contextlib.closing(NetProgram(hub)) as made:
        yield made


@pytest.fixture
def online(net: NetProgram) -> NetProgram:
    """A program whose lines are both started."""
    net.start(0)
    net.start(1)
    return net


@pytest.fixture
def other_net(connect: Connect) -> Iterator[NetProgram]:
    """Another program on the same hub."""
    with contextlib.closing(NetProgram(connect("second program"))) as made:
        yield made


@pytest.fixture
def virtual_net(virtual: Virtual) -> Iterator[NetProgram]:
    """A program on a hub of its own in virtual time, which stands still while nobody waits."""
    with contextlib.closing(NetProgram(virtual.hub)) as made:
        yield made


@pytest.fixture
def message() -> Any:
    """Makes a message of an identifier, its data, and more properties."""
    return lambda *made_of, **properties: _filled(v3.CanMessage(), *made_of, **properties)


@pytest.fixture
def cyclic() -> Any:
    """Makes a cyclic message of an identifier, its data, and more properties."""
    return lambda *made_of, **properties: _filled(v3.CanCyclicTXMsg(), *made_of, **properties)


def _filled(made: v3.CanMessage, identifier: int, data: bytes = b"", /, **properties: Any) -> v3.CanMessage:
    made.identifier, made.data_length = identifier, len(data)
    for index, byte in enumerate(data):
        made[index] = byte
    for name, value in properties.items():
        setattr(made, name, value)
    return made
