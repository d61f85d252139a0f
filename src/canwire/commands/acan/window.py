"""What the windows of WCT and CANSPY share: menus over a text, and dialogs. Needs Textual: canwire[tools].

F10, or a click, opens a menu; arrows and Enter choose, Escape closes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar, NamedTuple

from textual import events, on
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.message import Message
from textual.screen import ModalScreen
from textual.widgets import Input, Label, OptionList, Static
from textual.widgets.option_list import Option

from canwire import CanwireError


class Menu(NamedTuple):
    """A title, and entries with the action each one runs."""

    title: str
    entries: tuple[tuple[str, str], ...]


class Field(NamedTuple):
    """An entry of a dialog; the hint is below while it has the focus."""

    title: str
    value: str
    hint: str


class News(Message):
    """A notification that input has arrived; posted from the driver's thread."""


class Title(Label):
    """The title of a menu, in the bar."""

    def __init__(self, menu: Menu, number: int) -> None:
        super().__init__(f" {menu.title} ", markup=False)
        self._number = number

    def on_click(self) -> None:
        app = self.app
        assert isinstance(app, Window)
        app.open_menu(self._number)


class PullDown(ModalScreen[str]):
    """One open menu; its result is the chosen action, "" for none."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,f10", "dismiss('')"),
        Binding("left", "turn(-1)"),
        Binding("right", "turn(1)"),
        Binding("enter", "choose"),  # before the list has the focus
    ]

    def __init__(self, menus: Sequence[Menu], number: int) -> None:
        super().__init__()
        self._menus = menus
        self._number = number

    def compose(self) -> ComposeResult:
        with Vertical(id="menu"):
            yield OptionList(id="entries")

    def on_mount(self) -> None:
        self.action_turn(0)

    def action_turn(self, step: int) -> None:
        """Turn to the next menu in the direction of `step`."""
        self._number = (self._number + step) % len(self._menus)
        entries = self.query_one("#entries", OptionList)
        entries.border_title = self._menus[self._number].title
        entries.clear_options()
        entries.add_options([Option(text, id=action) for text, action in self._menus[self._number].entries])
        entries.highlighted = 0
        entries.focus()

    def action_choose(self) -> None:
        """Close the menu; its result is the action of the highlighted entry."""
        entries = self._menus[self._number].entries
        self.dismiss(entries[self.query_one("#entries", OptionList).highlighted or 0][1])

    @on(OptionList.OptionSelected)
    def _chosen(self, event: OptionList.OptionSelected) -> None:
        self.dismiss(event.option_id or "")


class Dialog(ModalScreen[bool]):
    """Fields to fill in; Enter hands them to `done`, and what that refuses is shown below them. Escape cancels.

    `earlier` are values to choose the first field from.
    """

    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "dismiss(False)")]

    def __init__(
        self,
        title: str,
        fields: Sequence[Field],
        done: Callable[[Mapping[str, str]], None],
        earlier: Sequence[str] = (),
    ) -> None:
        super().__init__()
        self._title = title
        self._fields = fields
        self._done = done
        self._earlier = earlier

    def compose(self) -> ComposeResult:
        with Vertical(id="dialog") as box:
            box.border_title = self._title
            for number, field in enumerate(self._fields):
                with Horizontal(classes="field"):
                    yield Label(field.title, markup=False)
                    yield Input(field.value, id=f"field{number}", compact=True)
            if self._earlier:
                yield OptionList(*[Option(text) for text in self._earlier], id="earlier", markup=False)
            yield Static(id="why", markup=False)

    def on_descendant_focus(self, event: events.DescendantFocus) -> None:
        """What the field with the focus is for."""
        at = (event.widget.id or "").removeprefix("field")
        hint = f"{self._fields[int(at)].hint}. " if at.isdigit() else ""
        self.query_one("#why", Static).update(f"{hint}Enter: OK, Escape: cancel")

    @on(OptionList.OptionSelected)
    def _earlier_chosen(self, event: OptionList.OptionSelected) -> None:
        first = self.query_one("#field0", Input)
        first.value = self._earlier[event.option_index]
        first.focus()

    @on(Input.Submitted)
    def _submitted(self) -> None:
        values = {
            field.title: self.query_one(f"#field{number}", Input).value
            for number, field in enumerate(self._fields)
        }
        try:
            self._done(values)
        except (CanwireError, OSError) as error:
            self.query_one("#why", Static).update(str(error))
        else:
            self.dismiss(True)


class Window(App[None]):
    """Menus in the first line, a status in the last one. What the driver raises ends it: see `finish`."""

    CSS = """
    #bar { height: 1; background: $primary; color: $text; }
    #status { height: 1; background: $panel; color: $text-muted; }
    PullDown { align: left top; background: $background 0%; }
    #menu { margin: 1 1; width: 40; height: auto; }
    #entries { height: auto; border: solid $primary; }
    Dialog { align: center middle; background: $background 50%; }
    #dialog { width: 76; height: auto; max-height: 90%; border: solid $primary; padding: 0 1; }
    .field { height: 1; }
    .field Label { width: 12; }
    .field Input { width: 1fr; }
    #earlier { height: auto; max-height: 10; }
    #why { height: auto; color: $text-muted; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("f10", "menu", "Menu"),
        Binding("ctrl+c,ctrl+q", "quit", "Quit", priority=True),
    ]
    ENABLE_COMMAND_PALETTE = False
    MENUS: ClassVar[tuple[Menu, ...]] = ()
    CHECK_S = 0.5

    failure: CanwireError | OSError | None = None

    def finish(self) -> int:
        """Run until it is closed; raises what ended it."""
        try:
            self.run()
        finally:
            self.end()
        if self.failure is not None:
            raise self.failure
        return self.return_code or 0

    # what each window has

    def begin(self) -> None:
        """Called when the window is complete on the screen. Raises CanwireError, OSError."""

    def end(self) -> None:
        """Called after the window has closed or failed to open."""

    def take(self) -> None:
        """Called when input for the window has arrived."""

    def check(self) -> None:
        """Raises HubLost or Unplugged if no more input can arrive."""

    # what all have

    def bar(self) -> ComposeResult:
        with Horizontal(id="bar"):
            for number, menu in enumerate(self.MENUS):
                yield Title(menu, number)
            yield Label("  F10: menus", markup=False)

    def on_mount(self) -> None:
        self.guarded(self.begin)
        self.set_interval(self.CHECK_S, lambda: self.guarded(self.check))

    @on(News)
    def _news(self) -> None:
        self.guarded(self.take)

    def guarded(self, work: Callable[[], None]) -> None:
        """Do it; what goes wrong ends the window."""
        if self.failure is not None:
            return
        try:
            work()
        except (CanwireError, OSError) as error:
            self.failure = error
            self.exit(return_code=2)

    def wake(self) -> None:
        """Report from any thread that there is something to take."""
        self.post_message(News())

    def tell(self, what: str) -> None:
        """Show text in the last line."""
        self.screen_stack[0].query_one("#status", Static).update(what)

    def action_menu(self) -> None:
        self.open_menu(0)

    def open_menu(self, number: int) -> None:
        def run(action: str | None) -> None:
            if action:
                self.call_later(self.run_action, action)

        if len(self.screen_stack) == 1:
            self.push_screen(PullDown(self.MENUS, number), run)
