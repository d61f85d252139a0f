"""The actions of the page on a send window: its generators, and Abort Transmission."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.web.cancheck.typed import typed_recipe

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire.web.actions import Call
    from canwire.web.cancheck.checking import Checking
    from canwire.web.cancheck.send import SendWindow

_LAST = 0xFFFF_FFFF  # of indices; a generator that is not there is named by the window


class SendDoing:
    """Fields: number (of the handle, hex) and, for one generator, index."""

    def __init__(self, checking: Checking) -> None:
        self._checking = checking

    @property
    def actions(self) -> dict[str, Callable[[Call], str]]:
        return {
            "abort": self.abort,
            "generator": self.generator,
            "edit": self.edit,
            "cancel-edit": self.cancel_edit,
            "activate": self.activate,
            "pause": self.pause,
            "activate-all": self.activate_all,
            "pause-all": self.pause_all,
        }

    def abort(self, call: Call) -> str:
        return call.word("cancheck.aborted", count=self._sender(call).abort())

    def generator(self, call: Call) -> str:
        """Save the generator's window by Activate or Pause (`state`): a new generator, or the
        changed one of `index`."""
        window, fields = self._sender(call), call.fields
        active = fields.choice("state", ("active", "paused")) == "active"
        index = fields.whole("index", 0, _LAST) if fields.text("index") else None
        recipe = typed_recipe(
            fields, call.word, align=window.align, extended=self._checking.program.port.extended
        )
        if index is None:
            index = window.generators.add(recipe, active=active)
        else:
            window.generators.change(index, recipe, active=active)
        return self._done(call, "cancheck.generator-active" if active else "cancheck.generator-paused", index)

    def edit(self, call: Call) -> str:
        window, index = self._sender(call), self._index(call)
        window.generators.begin_edit(index)
        return self._done(call, "cancheck.generator-edited", index)

    def cancel_edit(self, call: Call) -> str:
        window, index = self._sender(call), self._index(call)
        window.generators.cancel_edit(index)
        return self._done(call, "cancheck.generator-as-before", index)

    def activate(self, call: Call) -> str:
        window, index = self._sender(call), self._index(call)
        window.generators.activate(index)
        return self._done(call, "cancheck.generator-active", index)

    def pause(self, call: Call) -> str:
        window, index = self._sender(call), self._index(call)
        window.generators.pause(index)
        return self._done(call, "cancheck.generator-paused", index)

    def activate_all(self, call: Call) -> str:
        self._sender(call).generators.activate_all()
        self._checking.program.changed()
        return call.word("cancheck.all-active")

    def pause_all(self, call: Call) -> str:
        self._sender(call).generators.pause_all()
        self._checking.program.changed()
        return call.word("cancheck.all-paused")

    def _done(self, call: Call, key: str, index: int) -> str:
        self._checking.program.changed()
        return call.word(key, index=f"{index:X}")

    def _index(self, call: Call) -> int:
        index = call.fields.whole("index", 0, _LAST)
        call.fields.check()
        return index

    def _sender(self, call: Call) -> SendWindow:
        number = call.fields.hexadecimal("number", 0, 0xFFFF_FFFF)
        call.fields.check()
        return self._checking.program.sender(number)
