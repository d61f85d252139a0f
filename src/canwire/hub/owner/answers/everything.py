"""All requests that a hub answers. A new kind of request needs a function in one of these files, or a new file here."""

from __future__ import annotations

from canwire.hub.owner.answers import (
    boards,
    buses,
    channels,
    chips,
    clock,
    cyclic,
    faults,
    fifos,
    filters,
    leases,
    lin,
    lines,
    lockstep,
    notes,
)
from canwire.hub.owner.answers.registry import Answers

ANSWERS = Answers(
    boards.answers,
    leases.answers,
    lines.answers,
    filters.answers,
    channels.answers,
    cyclic.answers,
    lin.answers,
    chips.answers,
    buses.answers,
    faults.answers,
    fifos.answers,
    notes.answers,
    clock.answers,
    lockstep.answers,
)
