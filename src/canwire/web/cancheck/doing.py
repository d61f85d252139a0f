"""The actions of the page on CanCheck: its main window, its other windows, its registry dialog."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from canwire.candrv import EVERY_EVENT, unload
from canwire.web.cancheck.receive import ReceiveWindow
from canwire.web.cancheck.registry import Entry, RegistryDialog, ports

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire.candrv.registry.file import Value
    from canwire.web.actions import Call
    from canwire.web.cancheck.checking import Checking
    from canwire.web.cancheck.program import Window
    from canwire.web.fields import Fields

DWORD = 0xFFFF_FFFF
FASTEST = 1_000_000  # bit/s
OPENINGS = {"send": (False, True), "receive": (True, False), "both": (True, True)}


class MainDoing:
    """The buttons of the main window and of the registry dialog."""

    def __init__(self, checking: Checking) -> None:
        self._checking = checking

    @property
    def actions(self) -> dict[str, Callable[[Call], str]]:
        return {
            "start": self.start,
            "leave": self.leave,
            "restart": self.restart,
            "rate": self.rate,
            "mode": self.mode,
            "format": self.format,
            "command": self.command,
            "open": self.open,
            "close": self.close,
            "registry": self.registry,
        }

    def start(self, call: Call) -> str:
        """Start CanCheck on a port; if it runs already, switch to this port."""
        port = _port(call)
        self._checking.start(call.desk.link.hub, port)
        return call.word("cancheck.started", port=port)

    def leave(self, call: Call) -> str:
        self._checking.leave()
        return call.word("cancheck.left")

    def restart(self, call: Call) -> str:
        """Restart the port's driver, so that it reads the registry again."""
        port = _port(call)
        unload(call.desk.link.hub, port)
        return call.word("cancheck.restarted", port=port)

    def rate(self, call: Call) -> str:
        rate = call.fields.whole("rate", 1, FASTEST)
        call.fields.check()
        self._checking.program.port.set_rate(rate)
        self._checking.program.changed()
        return call.word("cancheck.set-rate", rate=rate)

    def mode(self, call: Call) -> str:
        mode = call.fields.whole("mode", 0, 1)
        call.fields.check()
        self._checking.program.port.set_mode(mode)
        self._checking.program.changed()
        return call.word("cancheck.set-mode", mode="AB"[mode])

    def format(self, call: Call) -> str:
        form = call.fields.whole("format", 0, 2)
        call.fields.check()
        self._checking.program.port.set_format(form)
        self._checking.program.changed()
        return call.word("cancheck.set-format")

    def command(self, call: Call) -> str:
        number = call.fields.whole("number", 0, 255)
        name = call.fields.text("name", longest=40)
        call.fields.check()
        self._checking.program.port.command(number)
        self._checking.program.changed()
        return call.word("cancheck.commanded", name=name or number)

    def open(self, call: Call) -> str:
        kind = call.fields.choice("kind", OPENINGS)
        call.fields.check()
        receive, send = OPENINGS[kind]
        window = self._checking.open(receive=receive, send=send)[0]
        return call.word("cancheck.opened", number=f"{window.number:X}")

    def close(self, call: Call) -> str:
        number = _number(call.fields)
        call.fields.check()
        self._checking.close(number)
        return call.word("cancheck.closed", number=f"{number:X}")

    def registry(self, call: Call) -> str:
        """Save the registry dialog (its button OK)."""
        dialog = RegistryDialog(self._checking.program.port.name)
        values = {entry.name: _value(call.fields, entry) for entry in dialog.entries()}
        call.fields.check()
        changed = dialog.ok(values)
        if not changed:
            return call.word("cancheck.registry-same")
        return call.word("cancheck.registry-written", names=", ".join(changed))


class WindowDoing:
    """The buttons of the receive windows, and those of all lists."""

    def __init__(self, checking: Checking) -> None:
        self._checking = checking

    @property
    def actions(self) -> dict[str, Callable[[Call], str]]:
        return {
            "overrun": self.overrun,
            "toggle": self.toggle,
            "all-events": self.all_events,
            "no-events": self.no_events,
            "filter": self.filter,
            "clear": self.clear,
            "open-log": self.open_log,
            "close-log": self.close_log,
        }

    def overrun(self, call: Call) -> str:
        self._receiver(call).clear_overrun()
        return call.word("cancheck.overrun-cleared")

    def toggle(self, call: Call) -> str:
        window, kind = self._receiver(call), call.fields.whole("event", 1, int(EVERY_EVENT))
        call.fields.check()
        window.toggle(kind)
        return call.word("cancheck.mask-set", mask=f"{window.mask:03X}")

    def all_events(self, call: Call) -> str:
        return self._mask(call, int(EVERY_EVENT))

    def no_events(self, call: Call) -> str:
        return self._mask(call, 0)

    def filter(self, call: Call) -> str:
        window = self._receiver(call)
        code, mask = (call.fields.hexadecimal(name, 0, DWORD) for name in ("code", "mask"))
        call.fields.check()
        window.set_filter(code, mask)
        return call.word("cancheck.filter-set", code=f"{code:08X}", mask=f"{mask:08X}")

    def clear(self, call: Call) -> str:
        self._receiver(call).list.clear()
        return call.word("cancheck.cleared")

    def open_log(self, call: Call) -> str:
        """Open a log file in the folder where the server was started: a typed name cannot select another folder."""
        window, fields = self._window(call), call.fields
        name = fields.text("file", longest=100, empty=False)
        if name and (not re.fullmatch(r"[\w ()+.-]+", name) or name.startswith(".")):
            fields.fault("file", call.word("cancheck.bad-file"))
        fields.check()
        try:
            window.list.open_log(Path.cwd() / name, overwrite=fields.flag("overwrite"))
        except FileExistsError:
            fields.fault("file", call.word("cancheck.file-exists", name=name))
        except OSError as error:
            fields.fault("file", f"{name}: {error.strerror}")
        fields.check()
        return call.word("cancheck.log-opened", name=name)

    def close_log(self, call: Call) -> str:
        self._window(call).list.close_log()
        return call.word("cancheck.log-closed")

    def _mask(self, call: Call, mask: int) -> str:
        window = self._receiver(call)
        window.mask = mask
        return call.word("cancheck.mask-set", mask=f"{mask:03X}")

    def _receiver(self, call: Call) -> ReceiveWindow:
        number = _number(call.fields)
        call.fields.check()
        return self._checking.program.receiver(number)

    def _window(self, call: Call) -> Window:
        number, kind = _number(call.fields), call.fields.choice("kind", ("send", "receive"))
        call.fields.check()
        return self._checking.program.window(number, kind)


def _port(call: Call) -> str:
    port = call.fields.choice("port", ports())
    call.fields.check()
    return port


def _number(fields: Fields) -> int:
    return fields.hexadecimal("number", 0, DWORD)


def _value(fields: Fields, entry: Entry) -> Value | None:
    if entry.text:
        return fields.text(entry.name)
    if entry.optional and not fields.text(entry.name):
        return None
    if entry.hexadecimal:
        return fields.hexadecimal(entry.name, entry.low, entry.high)
    return fields.whole(entry.name, entry.low, entry.high)
