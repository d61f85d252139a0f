"""What all tests share: canwire's own pytest plugin, whether canwire is installed or not."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import hypothesis
import pytest

from canwire import pytest_plugin
from tests.hubs import runs

# a busy machine is no bug: timing belongs to the benchmarks
# in CI the same examples each time; whoever develops gets new ones
hypothesis.settings.register_profile("canwire", deadline=None, derandomize=bool(os.environ.get("CI")))
hypothesis.settings.load_profile("canwire")


def pytest_configure(config: pytest.Config) -> None:
    """Installed, pytest has found the plugin by its entry point already, under that name."""
    if not config.pluginmanager.is_registered(pytest_plugin):
        config.pluginmanager.register(pytest_plugin, "canwire")


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """`-m smoke` is for newcomers: it does not even import the files that have none of these tests."""
    if config.option.markexpr != "smoke" or not collection_path.name.startswith("test_"):
        return None
    return None if "mark.smoke" in collection_path.read_text("utf-8") else True


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Of the behaviour tests over the network some run always, all of them with CANWIRE_TEST_NETWORK=all."""
    left_out = [item for item in items if not runs(item)]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if runs(item)]


@pytest.fixture(autouse=True, scope="session")
def _state_of_its_own(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Nothing that tests leave behind is found by a user's programs, nor the reverse."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        yield
