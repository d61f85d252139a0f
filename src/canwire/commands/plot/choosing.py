"""Chooses signals of databases by name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING, NamedTuple

from canwire import BadValue

if TYPE_CHECKING:
    from canwire import MessageDescription, SignalDescription
    from canwire.commands.databases.chosen import Databases


class Label(NamedTuple):
    """A signal with its message, unit and value texts."""

    message: str
    signal: str
    unit: str
    choices: tuple[tuple[float, str], ...]  # by physical value

    def __str__(self) -> str:
        return f"{self.message}.{self.signal}"


class Chosen(NamedTuple):
    """The chosen signals, in the order of the command line."""

    databases: Databases
    labels: tuple[Label, ...]

    @property
    def messages(self) -> dict[str, list[Label]]:
        """The chosen signals of each message."""
        found: dict[str, list[Label]] = {}
        for label in self.labels:
            found.setdefault(label.message, []).append(label)
        return found


def choose_signals(databases: Databases, words: Sequence[str]) -> Chosen:
    """Choose by `Message.Signal`, `Signal` or `Message`. Raises BadValue with similar names, or with all matches."""
    messages: dict[str, MessageDescription] = {}
    for database in databases.all:
        messages = {**database.messages, **messages}  # of two with one name the first defines the unit
    paths = ", ".join(database.path for database in databases.all)
    found = [label for word in words for label in _meant(messages, word, paths)]
    return Chosen(databases, tuple(dict.fromkeys(found)))


def _meant(messages: Mapping[str, MessageDescription], word: str, paths: str) -> list[Label]:
    name, dot, signal = word.partition(".")
    if dot and name in messages:
        signals = messages[name].signals
        if signal not in signals:
            raise BadValue(f"{word}: no such signal; {_near(signal, signals)}")
        return [_label(messages[name], signals[signal])]
    if word in messages:
        message = messages[word]
        return [_label(message, one) for one in message.signals.values()]
    holders = [one for one in messages.values() if word in one.signals]
    if len(holders) > 1:
        raise BadValue(f"{word}: which one? {', '.join(f'{one.name}.{word}' for one in holders)}")
    if not holders:
        every = [*messages, *(name for one in messages.values() for name in one.signals)]
        raise BadValue(f"{word}: neither a signal nor a message of {paths}; {_near(word, every)}")
    return [_label(holders[0], holders[0].signals[word])]


def _label(message: MessageDescription, signal: SignalDescription) -> Label:
    choices = tuple((raw * signal.scale + signal.offset, text) for raw, text in signal.choices.items())
    return Label(message.name, signal.name, signal.unit, choices)


def _near(wrong: str, names: Iterable[str]) -> str:
    by_lower = {name.lower(): name for name in names}
    near = [by_lower[found] for found in get_close_matches(wrong.lower(), by_lower, 3)]
    return f"did you mean {' or '.join(near)}?" if near else f"there are {', '.join(list(names)[:12])}"
