"""The table in a terminal's window. Needs Textual: canwire[tools]."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from textual import on
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.css.query import NoMatches
from textual.widgets import Footer, Input, Static

from canwire import CanwireError
from canwire.commands.live.decoding import Decode
from canwire.commands.view.columns import Wanted, format_csv, texts_of
from canwire.commands.view.rows import Rows
from canwire.commands.view.table import Row, Table

if TYPE_CHECKING:
    from canwire.commands.live.listening import Listening

_LOOK_S = 0.2
_AT_ONCE = 32_768


class ViewScreen(App[None]):
    """A screen of rows that follow the bus. `failure` is the error that ended it, if the user did not.

    `folder` is where tables are saved; `clock` names them.
    """

    CSS = """
    #filter { height: 1; border: none; padding: 0 1; background: $panel; }
    #titles { height: 1; background: $primary; color: $text; }
    #rows { height: 1fr; }
    #signals { height: auto; max-height: 10; background: $panel; padding: 0 1; display: none; }
    #status { height: 1; background: $panel; color: $text-muted; padding: 0 1; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("space", "pause", "Pause"),
        Binding("slash", "filter", "Filter"),
        Binding("s", "save", "Save"),
        Binding("c", "clear", "Clear"),
        Binding("escape", "rows", "Table", show=False),
        Binding("q", "quit", "Quit"),
        Binding("ctrl+c", "quit", "Quit", priority=True, show=False),
    ]
    ENABLE_COMMAND_PALETTE = False

    def __init__(
        self,
        listening: Listening,
        table: Table,
        decode: Decode | None = None,
        *,
        folder: Path | None = None,
        clock: Callable[[], datetime] = datetime.now,
    ) -> None:
        super().__init__()
        self.failure: CanwireError | OSError | None = None
        self.table = table
        self._listening = listening
        self._decode = decode
        self._folder = Path() if folder is None else folder
        self._clock = clock
        self._wanted = Wanted("", decode)
        self._held: list[Row] | None = None
        self._note = ""

    def compose(self) -> ComposeResult:
        yield Input(placeholder="filter: 123, 100-1FF, ~123, or part of a name", id="filter", compact=True)
        yield Static(id="titles", markup=False)
        yield Rows(self._decode, id="rows")
        yield Static(id="signals", markup=False)
        yield Static(id="status", markup=False)
        yield Footer()

    def on_mount(self) -> None:
        self.query_one(Rows).focus()
        self.query_one("#signals").display = self._decode is not None
        self.set_interval(_LOOK_S, self.look)
        self.look()

    def look(self) -> None:
        """Show the frames received since the previous call."""
        try:
            for source, records in self._listening.take(_AT_ONCE, 0):
                self.table.take(source.name, records)
        except (CanwireError, OSError) as error:
            self.failure = error
            self.exit(return_code=2)
            return
        self.show()

    def show(self) -> None:
        """Show the rows that match the filter, and the text below them."""
        try:
            rows, titles, signals, status = self._widgets()
        except NoMatches:  # the window is being taken down
            return
        rows.show([row for row in self._rows() if self._wanted.accepts(row)])
        titles.update(rows.titles)
        signals.update(rows.signals)
        status.update(self._status(rows.count))

    def _widgets(self) -> tuple[Rows, Static, Static, Static]:
        titles, signals, status = (self.query_one(f"#{id}", Static) for id in ("titles", "signals", "status"))
        return self.query_one(Rows), titles, signals, status

    def action_pause(self) -> None:
        """Freeze the shown rows, or continue; frames are counted in both cases."""
        self._held = None if self._held is not None else [row.copy() for row in self.table.rows]
        self.show()

    def action_filter(self) -> None:
        self.query_one("#filter", Input).focus()

    def action_rows(self) -> None:
        self.query_one(Rows).focus()

    def action_clear(self) -> None:
        """Remove all rows and counts."""
        self.table.clear()
        self._held = None
        self.show()

    def action_save(self) -> None:
        """Save the shown rows as CSV."""
        path = self._folder / f"canwire-view-{self._clock():%Y%m%d-%H%M%S}.csv"
        shown = [texts_of(row, self._decode) for row in self._rows() if self._wanted.accepts(row)]
        try:
            path.write_text(format_csv(shown), encoding="utf-8", newline="\n")
        except OSError as error:
            self._note = f"not saved: {error}"
        else:
            self._note = f"saved {len(shown)} rows to {path}"
        self.show()

    @on(Input.Changed, "#filter")
    def _typed(self, event: Input.Changed) -> None:
        self._wanted = Wanted(event.value, self._decode)
        self.show()

    def on_descendant_focus(self) -> None:
        """Show the keys of the widget that has the focus now."""
        self.show()

    @on(Rows.Moved)
    def _moved(self) -> None:
        self.show()

    @on(Input.Submitted, "#filter")
    def _entered(self) -> None:
        self.action_rows()

    def _rows(self) -> Sequence[Row]:
        return self.table.rows if self._held is None else self._held

    def _status(self, shown: int) -> str:
        told = [f"{shown} of {len(self.table)} identifiers", f"{self.table.frames} frames"]
        told.append(f"{self.table.errors} errors")
        if self._held is not None:
            told.append("PAUSED")
        if isinstance(self.focused, Input):
            told.append("typing a filter: Enter ends")
        if self._note:
            told.append(self._note)
        return "  ".join(told)
