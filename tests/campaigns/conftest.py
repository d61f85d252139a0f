"""What tests of campaigns share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.warm.spawned import spawned_warm


@pytest.fixture
def warm_workers() -> Iterator[None]:
    """The workers of a campaign start warm: not for tests of their start."""
    with spawned_warm():
        yield
