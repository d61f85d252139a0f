"""What comes of one file: the row of a table, for a log or a database that somebody else made."""

from __future__ import annotations

from typing import NamedTuple

OUTCOMES = {
    "same": "read, as the other reader does, or by both in the same way refused",
    "alone": "read by us, and the other reader refuses it or there is none",
    "explained": "read otherwise than the other reader does, which is known to be its fault",
    "says so": "read otherwise than the other reader does, and our faults name what we left out",
    "refused": "refused by us with its reason",
    "differs": "read otherwise, without a word",
    "crash": "an error that is none of canwire's",
    "too long": "no end within the time limit",
}
"""The last three are our faults, or the other reader's: each has to be looked at."""


class Told(NamedTuple):
    """`outcome` is one of OUTCOMES, `detail` the numbers, the first difference or the reason."""

    outcome: str
    detail: str
