"""The names and cycle times of identifiers, from databases."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from canwire import Frame, LinFrame

if TYPE_CHECKING:
    from canwire import IdentifierStatistics, MessageDescription
    from canwire.commands.databases.chosen import Databases


class Expected:
    """The expected messages of each channel, by identifier."""

    def __init__(self, databases: Databases) -> None:
        self._databases = databases

    def message(self, one: IdentifierStatistics) -> MessageDescription | None:
        """The message of the first database of the channel that knows the identifier; None if none does."""
        frame = LinFrame(one.id) if one.lin else Frame(one.id, extended=one.extended)
        found = (database.message_of(frame) for database in self._databases.of(one.channel))
        return next((message for message in found if message is not None), None)

    def deviation(self, one: IdentifierStatistics) -> float | None:
        """The percentage by which the mean period exceeds the cycle time; None if either is unknown."""
        message = self.message(one)
        if message is None or not message.cycle_s or one.mean_s is None:
            return None
        return 100 * (one.mean_s / message.cycle_s - 1)

    def missing(self, found: Iterable[IdentifierStatistics]) -> list[MessageDescription]:
        """Messages with a cycle time that do not occur in the log."""
        met = {message.name for message in map(self.message, found) if message is not None}
        return [
            message
            for database in self._databases.all
            for message in database.messages.values()
            if message.cycle_s and message.name not in met
        ]
