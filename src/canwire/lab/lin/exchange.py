"""A request of a master through the transport layer, and its answer."""

from __future__ import annotations

from canwire.boards.lin.exchange import LinExchange
from canwire.boards.lin.line import LinLine
from canwire.errors import CanwireError
from canwire.lab.time import LabTime
from canwire.values.checks import nanoseconds

_LOOK_NS = 1_000_000


def exchange(time: LabTime, line: LinLine, nad: int, payload: bytes, within: float) -> bytes:
    """Send, let time pass, and return the answer; raises NotReceived, and errors of the line."""
    answers: list[bytes | CanwireError] = []
    with time.touch():
        LinExchange(line, nad, payload, nanoseconds("within", within), answers.append).begin()
    while not answers:
        time.run_until(time.now_ns + _LOOK_NS)
    found = answers[0]
    if isinstance(found, CanwireError):
        raise found
    return found
