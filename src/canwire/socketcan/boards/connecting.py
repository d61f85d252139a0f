"""A thread that connects to a hub again, so that programs do not wait for the network meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Callable

import canwire
from canwire import Absence, CanwireError, Hub, HubLost


class Connecting:
    """`found` is called in the thread, with the hub."""

    def __init__(self, address: str, found: Callable[[Hub], object]) -> None:
        self._address = address
        self._found = found
        self._absence = Absence()
        self._stopped = threading.Event()

    @property
    def lasts(self) -> bool:
        return self._absence.lasts

    def begin(self) -> None:
        """The hub is gone: look for it."""
        self._absence.failed(HubLost("the hub is gone"))
        threading.Thread(target=self._run, name="canwire-connecting", daemon=True).start()

    def end(self) -> float:
        """The hub is in use again: how many seconds it was not."""
        return self._absence.end() or 0.0

    def stop(self) -> None:
        """Give up; a second call has no effect."""
        self._stopped.set()

    def _run(self) -> None:
        while not self._stopped.wait(self._absence.pause_s):
            try:
                hub = canwire.connect(self._address, name="canwire run", timed=False)
            except CanwireError as error:
                self._absence.failed(error)
            else:
                self._found(hub)
                return
