"""The JSON output of `canwire stats`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from canwire import IdentifierStatistics, Log, LogStatistics
    from canwire.commands.stats.expected import Expected


def facts_of(logs: Sequence[Log], found: LogStatistics, expected: Expected | None) -> dict[str, Any]:
    """Return all results, by the names of LogStatistics, ChannelStatistics and IdentifierStatistics."""
    facts = {
        "logs": [log.path for log in logs],
        "format": logs[0].format,
        "faults": sum(log.fault_count for log in logs),
        **asdict(found),
        "span_s": found.span_s,
        "channels": [{**asdict(channel), "peak": channel.peak} for channel in found.channels],
        "identifiers": [_identifier(one, expected) for one in found.identifiers],
    }
    if expected is not None:
        facts["missing"] = [
            {"message": message.name, "cycle_s": message.cycle_s}
            for message in expected.missing(found.identifiers)
        ]
    return facts


def _identifier(one: IdentifierStatistics, expected: Expected | None) -> dict[str, Any]:
    facts = asdict(one)
    if expected is not None:
        message = expected.message(one)
        facts["message"] = message.name if message else None
        facts["cycle_s"] = message.cycle_s if message else None
        facts["deviation_percent"] = expected.deviation(one)
    return facts
