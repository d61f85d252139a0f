"""What all tests share: canwire's own pytest plugin, whether canwire is installed or not."""

from __future__ import annotations

import atexit
import gc
import os
import signal
from collections.abc import Generator, Iterator
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from canwire import pytest_plugin
from tests import missing, warm, workers
from tests.cold import without_asammdf
from tests.effort import register_profiles
from tests.hubs import runs

register_profiles()

# what a user has chosen for programs: a hub, its configuration, the name and time of programs, python-can's usual bus
for _chosen in (
    *(f"CANWIRE_{name}" for name in ("HUB", "CONFIG", "NAME", "TIMED", "NETWORK", "SOCKETCAN")),
    *(f"CAN_{name}" for name in ("INTERFACE", "CHANNEL", "BITRATE", "CONFIG")),
):
    os.environ.pop(_chosen, None)

# programs in C leave no warm process behind: tests/native/test_warm.py
os.environ["CANWIRE_HELPER_STAYS"] = "0"
# numpy's own threads, which nothing here needs, keep a core busy for a tenth of a second in each program that loads it
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def pytest_configure(config: pytest.Config) -> None:
    """Installed, pytest has found the plugin by its entry point already, under that name."""
    if not config.pluginmanager.is_registered(pytest_plugin):
        config.pluginmanager.register(pytest_plugin, "canwire")
    config.pluginmanager.register(workers)
    if hasattr(os, "fork") and config.getoption("numprocesses", None):
        warm.share()
    hear_signals()


def hear_signals() -> None:
    """Started by nohup or a script's `&`, this process goes on ignoring signals; programs that tests start do not.

    A program that is started with a signal ignored leaves it so, and ours do; one that is handled, in whatever way, is
    the system's own again in a new program.
    """
    for name in ("SIGINT", "SIGQUIT", "SIGHUP", "SIGTERM"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, lambda *_: None)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """CANWIRE_MISSING=fail: no test is skipped for want of a package."""
    return missing.judged((yield))


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """The same for a whole file."""
    return missing.judged((yield))


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """`-m smoke` is for newcomers: it does not even import the files that have none of these tests."""
    if config.option.markexpr != "smoke" or not collection_path.name.startswith("test_"):
        return None
    return None if "mark.smoke" in collection_path.read_text("utf-8") else True


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Of the behaviour tests over the network some run always, all of them with CANWIRE_TEST_NETWORK=all.

    Long tests come first: as the last ones they would leave the other workers nothing to do.
    """
    items.sort(key=lambda item: item.get_closest_marker("long") is None)
    left_out = [item for item in items if not runs(item)]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if runs(item)]


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """What was collected stays: else each collection of garbage walks through all tests of the session.

    And garbage is collected seldom: a worker would do so for 7 of its 80 s.
    At the very end of a run without workers all goes as usual again, and libraries complain of what is still there.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(10_000, 20, 100)
        gc.enable()
        atexit.register(gc.unfreeze)


@pytest.fixture
def python_can_without_mf4(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Programs that this test starts cold load python-can in half of the time."""
    monkeypatch.setenv("PYTHONPATH", without_asammdf(tmp_path_factory.mktemp("cold")), prepend=os.pathsep)


@pytest.fixture
def ctrl_c() -> Iterator[None]:
    """SIGINT is Ctrl-C in this process, also where the tests were started without it, as by a script's `&`."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(autouse=True, scope="session")
def _apart_from_the_user(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Nothing that tests leave behind is found by a user's programs, nor the reverse: no hub, no state."""
    with ExitStack() as closing, pytest.MonkeyPatch.context() as patch:
        sockets = os.environ.get("CANWIRE_TESTS_RUNTIME")  # by a test that looks at what is left there
        if not sockets:  # a short path, as sockets need it
            sockets = closing.enter_context(TemporaryDirectory(prefix="canwire-", ignore_cleanup_errors=True))
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        patch.setenv("XDG_RUNTIME_DIR", sockets)
        yield
