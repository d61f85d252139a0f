"""CANSPY's window. Needs Textual: canwire[tools].

Source: INduCAN104 manual, "CAN Spy (CANSPY)".
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.widgets import Log, Static

from canwire.commands.acan.machines import rate_remarks
from canwire.commands.acan.spy import MESSAGES, Spy, Trace, clock
from canwire.commands.acan.window import Dialog, Field, Menu, Window

if TYPE_CHECKING:
    from canwire.acan import Driver

_MESSAGE, _FILE = "Message", "File"
_LIKE = "Like 00001001000 - 61 62, 00001001000 - | ab, 00001001000 R"
_NO_NAME = "No name: no longer"


class SpyScreen(Window):
    """The trace. `rates` are kHz and kbit/s for an uninitialised controller; `messages` are sent first."""

    TITLE = "CANSPY"
    MENUS = (
        Menu("File", (("Redirect to...", "redirect"), ("Quit", "quit"))),
        Menu("Control", (("Trace", "trace"), ("Clear", "clear"), ("Send...", "send"))),
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+t", "trace", "Trace"),
        Binding("ctrl+l", "clear", "Clear"),
        Binding("ctrl+s", "send", "Send"),
        Binding("ctrl+r", "redirect", "Redirect"),
    ]

    def __init__(
        self, driver: Driver, rates: tuple[int, int], file: Path | None = None, messages: Sequence[str] = ()
    ) -> None:
        super().__init__()
        self._rates = rates
        self._acan = driver
        self._file = file
        self._messages = messages
        self.spy = Spy(driver, Trace(clock, self._show), self.wake)

    def compose(self) -> ComposeResult:
        yield from self.bar()
        yield Log(id="trace", max_lines=2 * MESSAGES)
        yield Static(id="status", markup=False)

    def begin(self) -> None:
        self.query_one("#trace", Log).focus()
        self.spy.trace.redirect(self._file)
        self.spy.start(*self._rates)
        for message in self._messages:
            self.spy.send(message)
        self._tell()
        for line in rate_remarks(self._acan):
            self.spy.trace.write(line)

    def end(self) -> None:
        self.spy.stop()

    def take(self) -> None:
        self.spy.take()

    def check(self) -> None:
        self.spy.check()

    def action_trace(self) -> None:
        """Control/Trace: pause, or continue."""
        self.guarded(self.spy.toggle)
        self._tell()

    def action_clear(self) -> None:
        """Control/Clear: remove all lines of the trace."""
        self.spy.trace.clear()
        self._lines().clear()

    def action_send(self) -> None:
        """Control/Send: one message, a new one or one of the last ten."""
        last = self.spy.sent[0] if self.spy.sent else "00001001000 - "
        self._ask(Dialog("Send", [Field(_MESSAGE, last, _LIKE)], self._send, list(self.spy.sent)))

    def action_redirect(self) -> None:
        """File/Redirect to...: no name ends it."""
        self._ask(Dialog("Redirect to", [Field(_FILE, str(self._file or ""), _NO_NAME)], self._redirect))

    def _ask(self, dialog: Dialog) -> None:
        if len(self.screen_stack) == 1:
            self.push_screen(dialog)

    def _send(self, values: Mapping[str, str]) -> None:
        self.spy.send(values[_MESSAGE])

    def _redirect(self, values: Mapping[str, str]) -> None:
        name = values[_FILE].strip()
        file = Path(name).expanduser() if name else None
        self.spy.trace.redirect(file)
        self._file = file
        self._tell()

    def _show(self, line: str) -> None:
        log = self._lines()
        log.max_lines = len(self.spy.trace)  # what the trace has forgotten goes from the window, too
        log.write_line(line or " ")  # nothing would be no line

    def _lines(self) -> Log:
        return self.screen_stack[0].query_one("#trace", Log)

    def _tell(self) -> None:
        state = "trace on" if self.spy.trace.on else "trace off"
        self.tell(f"{state}, into {self._file}" if self._file else state)
