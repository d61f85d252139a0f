"""tests/workers.py: what a worker tells about a test."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from tests.workers import tell_only_results


def test_a_worker_tells_each_result_once_and_everything_that_did_not_pass() -> None:
    told: list[tuple[str, dict[str, Any]]] = []
    interactor = SimpleNamespace(sendevent=lambda name, **words: told.append((name, words)))
    plugins = SimpleNamespace(get_plugins=lambda: [object(), interactor])
    config: Any = SimpleNamespace(pluginmanager=plugins)
    tell_only_results(config)

    def report(when: str, outcome: str = "passed", *properties: tuple[str, str]) -> dict[str, Any]:
        return {"data": {"when": when, "outcome": outcome, "user_properties": list(properties)}}

    kept = [
        ("testreport", report("call")),
        ("testreport", report("call", "failed")),
        ("testreport", report("setup", "failed")),
        ("testreport", report("setup", "skipped")),
        ("testreport", report("teardown", "failed")),
        ("testreport", report("teardown", "passed", ("measured", "3"))),
        ("runtest_protocol_complete", {"item_index": 3, "duration": 0.1}),
        ("collectreport", {"data": {"outcome": "failed"}}),
    ]
    left_out = [
        ("logstart", {"nodeid": "a"}),
        ("logfinish", {"nodeid": "a"}),
        ("testreport", report("setup")),
        ("testreport", report("teardown")),
    ]
    for name, words in kept + left_out:
        interactor.sendevent(name, **words)
    assert told == kept
