"""One view of a source: the rows that pass its filter, and the answers to a viewer's requests."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy

from canwire.web.trace.answers import Answers, Shown
from canwire.web.trace.look import Ask, Look
from canwire.web.trace.store.described import Described, DescribedLines
from canwire.web.trace.store.filtering import BadFilter, Language, directed
from canwire.web.trace.store.kinds import Test
from canwire.web.trace.store.selection import Selection

if TYPE_CHECKING:
    from canwire.web.databases.loaded import Databases
    from canwire.web.trace.source import Source
    from canwire.web.words import Words


class Viewing:
    """The view that `look` describes; `fault` is the invalid part of its filter, `bad_rules` are the places of invalid
    rules.

    `before` is the previous view of the same viewer, None at first; unchanged parts are taken over from it.
    """

    def __init__(
        self,
        look: Look,
        source: Source,
        databases: Databases,
        viewer: object,
        before: Viewing | None,
        word: Words,
    ) -> None:
        same = before if before is not None and before.source is source else None
        self.look = look
        self.source: Source = source
        self.fault = ""
        self.bad_rules: list[int] = []
        self._databases = databases
        self._viewer = viewer
        self._grown: Callable[[], None] | None = None
        if before is not None and not same:
            before.source.want(viewer, ())
        source.want(viewer, look.lines)
        identifiers = source.history.identifiers
        self._table = identifiers
        if look.until is not None:
            paused = same is not None and same.look.until is not None
            self._table = same._table if same is not None and paused else identifiers.copy()
        self._before = numpy.zeros(0)
        if look.since:
            kept = same is not None and same.look.since == look.since
            self._before = same._before if same is not None and kept else identifiers.counts()
        self._answers = Answers(databases, word)
        self.selection: Selection
        self._indices: list[int] = []
        self._key: object = None
        if same is not None and same._key is not None:
            self._key, self._indices, self.selection = same._key, same._indices, same.selection
        else:
            self.selection = Selection(source.history, (), None, look.since)
        self.extend()

    @property
    def more(self) -> bool:
        """Whether some rows were not checked yet."""
        return self.selection.cursor < self.selection.end

    @property
    def state(self) -> object:
        """A value that is equal while there is nothing new to report."""
        return self.selection.count, self.selection.cursor, self.source.history.total

    def extend(self) -> None:
        """Find more rows that pass the filter; in steps if there are many."""
        indices = self.source.indices(self.look.lines)
        key = indices, self.look.filter, self.look.direction, self.look.since, self._databases.version
        if key != self._key:
            self._indices = indices
            self._compile()
            self.selection = Selection(self.source.history, indices, self._test, self.look.since)
        elif self._answers.rules is None:
            self._compile()
        self._key = key
        self.selection.stop(self.look.until)
        self.selection.extend()

    def answer(self, ask: Ask) -> bytes:
        """Return the head and the rows."""
        shown = Shown(self.look, self.source, self.selection, self.fault, self.bad_rules)
        if ask.by_frame:
            page = self._table.page(self._indices, self._test, self._before, max(ask.at, 0), ask.rows)
            return self._answers.by_frame(shown, page, self._table.left_out)
        found = self._find(ask)
        if found is not None:
            at = found - ask.rows // 2
            return self._answers.by_time(shown, max(at, self.selection.gone), ask.rows, found)
        at = self.selection.count - ask.rows if ask.at < 0 else ask.at
        at = max(at, self.selection.gone, 0)
        return self._answers.by_time(shown, at, ask.rows, None)

    def _find(self, ask: Ask) -> int | None:
        """Return the place that was searched for, -1 if not found; None if there was no search."""
        if ask.near is not None:
            return self.selection.place_of(ask.near)
        if ask.time_ns is not None:
            return self.selection.place_at(ask.time_ns)
        if not ask.find:
            return None
        found = self.selection.find(self._language().search(ask.find), ask.begin, ask.step)
        return -1 if found is None else found

    def listen(self, grown: Callable[[], None]) -> None:
        """Call `grown` whenever there are new rows."""
        self._grown = grown
        self.source.history.listen(grown)

    def unlisten(self) -> None:
        if self._grown is not None:
            self.source.history.unlisten(self._grown)
            self._grown = None

    def leave(self) -> None:
        """End the view of a viewer that has left."""
        self.unlisten()
        self.source.want(self._viewer, ())

    def _language(self) -> Language:
        return language_of(self.look, self.source, self._databases)

    def _compile(self) -> None:
        language = self._language()
        self.fault = ""
        self.bad_rules = []
        self._test: Test | None = None
        try:
            self._test = language.compile(self.look.filter)
        except BadFilter as bad:
            self.fault = str(bad) or self.look.filter
        if self.look.direction:
            self._test = directed(self._test, sent=self.look.direction == "T")
        rules = []
        for place, (text, colour) in enumerate(self.look.rules):
            try:
                test = language.compile(text)
            except BadFilter:
                self.bad_rules.append(place)
                continue
            if test is not None:
                rules.append((test, colour))
        self._answers.rules = rules


def language_of(look: Look, source: Source, databases: Databases) -> Language:
    """Return the filter language that knows the source's lines."""
    known: dict[str, list[int]] = {}
    groups: dict[str, list[int]] = {}
    for line in source.lines(look.lines):
        for name in {line.address.lower(), line.bus.lower()} - {""}:
            known.setdefault(name, []).append(line.number)
        groups.setdefault(databases.group(line.bus), []).append(line.number)
    described = [
        DescribedLines(databases.on(group), [number for number in numbers if number >= 0])
        for group, numbers in groups.items()
    ]
    return Language(Described(described), known)


def selected(look: Look, source: Source, databases: Databases) -> Selection:
    """Return all rows of a view as of now; raises BadFilter."""
    test = language_of(look, source, databases).compile(look.filter)
    if look.direction:
        test = directed(test, sent=look.direction == "T")
    selection = Selection(source.history, source.indices(look.lines), test, look.since)
    selection.stop(source.history.total if look.until is None else look.until)
    while selection.extend():
        pass
    return selection
