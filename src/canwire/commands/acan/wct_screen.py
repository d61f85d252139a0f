"""WCT's window. Needs Textual: canwire[tools].

Source: INduCAN104 manual, "Windows CAN Terminal (WCT)".
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from textual import events
from textual.app import ComposeResult
from textual.widgets import Log, Static

from canwire.commands.acan.machines import rate_remarks
from canwire.commands.acan.term import CTRL_T, CTRL_U, Printable
from canwire.commands.acan.wct import Settings, Wct, write_settings
from canwire.commands.acan.window import Dialog, Field, Menu, Window

if TYPE_CHECKING:
    from canwire.acan import Driver

_KEYS = {
    "enter": b"\r",
    "tab": b"\t",
    "backspace": b"\b",
    "ctrl+t": CTRL_T,
    "ctrl+u": CTRL_U,
    "escape": b"\x1b",
}
_UNSHOWN = str.maketrans("", "", "\a\b")
_LINES = 1000  # kept to scroll back


class Characters(Log):
    """What came; every key goes to the bus, but those that scroll and those of the window."""

    def on_key(self, event: events.Key) -> None:
        typed = _KEYS.get(event.key)
        if typed is None and event.is_printable and event.character:
            typed = event.character.encode()
        app = self.app
        if typed is not None and isinstance(app, WctScreen):
            event.stop()
            event.prevent_default()
            app.typed(typed)


class WctScreen(Window):
    """A terminal; `path` is WCT.INI, written when the settings are changed."""

    TITLE = "WCT"
    MENUS = (Menu("File", (("Quit", "quit"),)), Menu("Options", (("CAN...", "options"),)))

    def __init__(self, driver: Driver, settings: Settings, path: Path) -> None:
        super().__init__()
        self._path = path
        self._acan = driver
        self._printable = Printable()
        self.wct = Wct(driver, settings, self.wake)

    def compose(self) -> ComposeResult:
        yield from self.bar()
        yield Characters(id="characters", max_lines=_LINES)
        yield Static(id="status", markup=False)

    def begin(self) -> None:
        self.query_one("#characters", Log).focus()
        self.wct.start()
        self._tell()
        for line in rate_remarks(self._acan):
            self.tell(line)

    def end(self) -> None:
        self.wct.stop()

    def take(self) -> None:
        self._show(self.wct.terminal.received())

    def check(self) -> None:
        self.wct.terminal.check()

    def typed(self, keys: bytes) -> None:
        """Send typed text to the bus."""
        self.guarded(lambda: self._show(self.wct.terminal.typed(keys)))

    def action_options(self) -> None:
        """Open the dialog of Options/CAN."""
        texts, hints = self.wct.settings.texts(), Settings.hints()
        fields = [Field(name, text, f"{name}: {hints[name]}") for name, text in texts.items()]
        if len(self.screen_stack) == 1:
            self.push_screen(Dialog("CAN", fields, self._apply))

    def _apply(self, values: Mapping[str, str]) -> None:
        """Apply the settings immediately, then write them to the file."""
        settings = Settings.of_texts({name.lower(): value for name, value in values.items()})
        self.wct.apply(settings)
        self._tell()
        write_settings(self._path, settings)

    def _show(self, data: bytes) -> None:
        if data:
            text = self._printable.text(data).translate(_UNSHOWN)
            self.screen_stack[0].query_one("#characters", Log).write(text)
        if self.wct.terminal.complaints:
            self.tell(self.wct.terminal.complaints[-1])
            self.wct.terminal.complaints.clear()

    def _tell(self) -> None:
        now = self.wct.settings
        whom = f"machine {now.target}" if now.target else "all machines"
        switches = f"{', echo' if now.echo else ''}{', loop' if now.loop else ''}"
        self.tell(f"machine {now.local} to {whom}, {now.rate} kbit/s{switches}")
