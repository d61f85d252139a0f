"""Tests of pytest-asyncio, as published, in the fixture's virtual time."""

from __future__ import annotations

import pytest

pytest.importorskip("can")
pytest.importorskip("pytest_asyncio")

pytest_plugins = ["pytester"]
pytestmark = [pytest.mark.finding("first-hour 1"), pytest.mark.timeout(60)]

TESTS = """
import asyncio
import time

import can
import pytest

HEARD = []


@pytest.mark.asyncio
@pytest.mark.parametrize("number", range(2))
async def test_an_ecu_answers_after_an_hour(canwire_hub, number):
    with (
        can.Bus("can0", interface="canwire", hub=canwire_hub) as ecu,
        can.Bus("can0", interface="canwire", hub=canwire_hub) as tester,
    ):
        reader = can.AsyncBufferedReader()
        notifier = can.Notifier(ecu, [reader], loop=asyncio.get_running_loop())
        task = tester.send_periodic(can.Message(arbitration_id=0x120, is_extended_id=False), 1.0)
        heard = [await asyncio.wait_for(reader.get_message(), 2.0) for _ in range(3)]
        await asyncio.sleep(3600)
        with pytest.raises(asyncio.TimeoutError):
            await asyncio.wait_for(asyncio.Event().wait(), 0.5)
        task.stop()
        notifier.stop()
    HEARD.append(([message.timestamp for message in heard], time.monotonic()))
    assert HEARD[0] == HEARD[-1]
    assert 3602.5 <= time.monotonic() < 3603.5
"""


def test_the_hub_s_time_is_that_of_its_loops(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    pytester.makeini("[pytest]\nasyncio_default_fixture_loop_scope = function\n")
    pytester.makepyfile(TESTS)
    plugins = ("-p", "canwire.pytest_plugin", "-p", "pytest_asyncio.plugin", "-p", "no:cacheprovider")
    pytester.runpytest(*plugins).assert_outcomes(passed=2)
