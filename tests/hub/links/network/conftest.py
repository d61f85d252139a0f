"""The network's link is Linux' own: where its platform is not, there is one test, of the word that says so."""

from __future__ import annotations

import pytest

from canwire.platform import PORTABLE


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if PORTABLE:
        for item in items:
            if "links/network" in item.nodeid and "test_platform" not in item.nodeid:
                item.add_marker(pytest.mark.skip(reason="hubs of other machines need Linux' own platform"))
