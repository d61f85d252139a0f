"""The rows as Textual draws them: only those in sight are put into words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from rich.segment import Segment
from rich.style import Style
from rich.text import Text
from textual.binding import Binding, BindingType
from textual.geometry import Size
from textual.message import Message
from textual.scroll_view import ScrollView
from textual.strip import Strip

from canwire.commands.live.decoding import Decode
from canwire.commands.view.columns import TITLES, Texts, texts_of
from canwire.commands.view.table import Row

_CHANGED = Style(bold=True, color="black", bgcolor="yellow")
_CURSOR = Style(reverse=True)
_LONGEST_CLASSIC = 23  # columns of eight bytes
_LONGEST_FD = 191
_WIDE = 100  # of what is decoded, beyond the window


class Rows(ScrollView, can_focus=True):
    """A table of rows with a cursor. `signals` are those of the row there."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up", "move(-1)", show=False),
        Binding("down", "move(1)", show=False),
        Binding("pageup", "move(-20)", show=False),
        Binding("pagedown", "move(20)", show=False),
        Binding("home", "move(-1000000)", show=False),
        Binding("end", "move(1000000)", show=False),
    ]

    class Moved(Message):
        """Sent when the cursor has moved to another row."""

    def __init__(self, decode: Decode | None, *, id: str) -> None:
        super().__init__(id=id)
        self._decode = decode
        self._rows: Sequence[Row] = ()
        self._cursor = 0
        self._widths = (4, 8, 3, _LONGEST_CLASSIC, 7, 9, 7, 9)

    @property
    def count(self) -> int:
        return len(self._rows)

    @property
    def titles(self) -> Text:
        return Text(self._line(TITLES)[0], no_wrap=True)

    @property
    def signals(self) -> str:
        """Return a line for each signal of the row under the cursor."""
        if self._decode is None or not self._rows:
            return ""
        message = self._decode(self._rows[self._cursor].frame)
        if message is None:
            return "not in the database"
        return "\n".join([message.name, *(f"  {name}: {message.text(name)}" for name in message.signals)])

    def show(self, rows: Sequence[Row]) -> None:
        """Show these rows in place of the previous ones."""
        self._rows = rows
        self._cursor = max(0, min(self._cursor, len(rows) - 1))
        longest = max((len(row.key.line) for row in rows), default=0)
        data = (
            _LONGEST_FD
            if any(row.frame.fd and len(row.frame.data) > 8 for row in rows[:_WIDE])
            else _LONGEST_CLASSIC
        )
        self._widths = (max(4, longest), 8, 3, data, 7, 9, 7, 9)
        width = sum(self._widths) + 2 * len(self._widths) + (_WIDE if self._decode is not None else 0)
        self.virtual_size = Size(width, len(rows))
        self.refresh()

    def action_move(self, step: int) -> None:
        """Move the cursor by `step` rows, and scroll so that it is visible."""
        self._cursor = max(0, min(self._cursor + step, len(self._rows) - 1))
        top, height = self.scroll_offset.y, self.size.height
        if self._cursor < top:
            self.scroll_to(y=self._cursor, animate=False)
        elif self._cursor >= top + height:
            self.scroll_to(y=self._cursor - height + 1, animate=False)
        self.post_message(self.Moved())

    def render_line(self, y: int) -> Strip:
        """Return one line of the window."""
        left, top = self.scroll_offset
        at = y + top
        width = self.size.width
        if at >= len(self._rows):
            return Strip.blank(width, self.rich_style)
        row = self._rows[at]
        line, data_at = self._line(texts_of(row, self._decode))
        text = Text(line.ljust(left + width), no_wrap=True)
        if at == self._cursor and self.has_focus:
            text.stylize(_CURSOR)
        if not row.frame.remote:
            for place in row.changed:
                start = data_at + 3 * place
                text.stylize(_CHANGED, start, start + 2)
        segments = [Segment(part.text, part.style) for part in text.render(self.app.console) if part.text]
        strip = Strip(segments).apply_style(self.rich_style)
        return strip.crop_extend(left, left + width, self.rich_style)

    def _line(self, texts: Texts) -> tuple[str, int]:
        """Return the columns as one line, and the position at which the data begin."""
        line, id, length, data, count, period, least, most = self._widths
        head = f"{texts.line:<{line}}  {texts.id:>{id}}  {texts.length:>{length}}  "
        rest = (
            f"{texts.data:<{data}}  {texts.frames:>{count}}  {texts.period:>{period}}  {texts.least:>{least}}  "
            f"{texts.most:>{most}}  {texts.decoded}"
        )
        return head + rest, len(head)
