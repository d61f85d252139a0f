"""Hubs with faults to set: in virtual time, and reached in every way."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest

from canwire import Hub
from canwire.hub.owner.engine import Engine
from tests.hub.faults.bench import CONFIG
from tests.hubs import connected, embedded, fixtures

hub_process, hub_network, mortal_hub, connect = fixtures(CONFIG)

Programs = Callable[[str], Hub]


@pytest.fixture
def engine() -> Iterator[Engine]:
    with embedded(CONFIG, time="virtual") as made:
        yield made


@pytest.fixture
def program(engine: Engine) -> Iterator[Programs]:
    """Connections of programs to one hub in virtual time."""
    with ExitStack() as stack:
        yield lambda name: stack.enter_context(connected(engine, name))


@pytest.fixture
def hub(program: Programs) -> Hub:
    return program("test")
