"""The server's connection to the hub: it is restored when the hub is back, and interruptions are counted."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import canwire
from canwire import Event, HubError, HubLost

if TYPE_CHECKING:
    from canwire import Hub

_LOOK_S = 0.25
NAME = "canwire web"


class Gap(NamedTuple):
    """A period in which the hub was away, in seconds: up to now if it is not `over`."""

    seconds: float
    over: bool


class HubLink:
    """`hub` is the connection while it exists; a thread connects again whenever it is lost. Ends with `close`.

    `connect` makes a connection or raises HubError. Subscribers are called in that thread: `began(hub)` at each
    connection, immediately if one exists, and `ended()` when it is lost.
    """

    def __init__(self, connect: Callable[[], Hub]) -> None:
        self._connect = connect
        self._lock = threading.RLock()
        self._subscribers: list[tuple[Callable[[Hub], None], Callable[[], None]]] = []
        self._event = Event()
        self._closing = threading.Event()
        self._lost_at_s = 0.0
        self._gaps: list[float] = []
        self._hub: Hub | None = None
        self._adopt(connect())  # the first one has to be there
        self._thread = threading.Thread(target=self._run, name="hub link")
        self._thread.start()

    @property
    def hub(self) -> Hub:
        """The hub; raises HubLost while it is away."""
        hub = self._hub
        if hub is None or hub.lost:
            raise HubLost("the hub is away; the page continues by itself when the hub is back")
        return hub

    @property
    def there(self) -> bool:
        """Whether the hub is connected now."""
        hub = self._hub
        return hub is not None and not hub.lost

    @property
    def gaps(self) -> list[Gap]:
        """All periods in which the hub was away, the present one last."""
        with self._lock:
            gaps = [Gap(seconds, True) for seconds in self._gaps]
            if self._hub is None:
                gaps.append(Gap(time.monotonic() - self._lost_at_s, False))
        return gaps

    def subscribe(self, began: Callable[[Hub], None], ended: Callable[[], None]) -> None:
        """Call `began` and `ended` for connections from now on."""
        with self._lock:
            self._subscribers.append((began, ended))
            if self._hub is not None:
                began(self._hub)

    def close(self) -> None:
        """Close the connection; a second call does nothing."""
        if not self._closing.is_set():
            self._closing.set()
            self._event.set()
            self._thread.join()
            self._event.close()

    def _run(self) -> None:
        while not self._closing.is_set():
            if self._hub is None:
                self._try()
            else:
                self._event.wait()
                if self._hub.lost or self._closing.is_set():
                    self._drop()

    def _try(self) -> None:
        try:
            hub = self._connect()
        except (HubError, OSError):
            self._closing.wait(_LOOK_S)
            return
        with self._lock:
            self._gaps.append(time.monotonic() - self._lost_at_s)
            self._adopt(hub)

    def _adopt(self, hub: Hub) -> None:
        hub.watch(self._event)  # also set when the hub ends
        self._hub = hub
        for began, _ in self._subscribers:
            began(hub)

    def _drop(self) -> None:
        with self._lock:
            hub, self._hub = self._hub, None
            self._lost_at_s = time.monotonic()
            for _, ended in self._subscribers:
                ended()
        if hub is not None:
            hub.unwatch(self._event)
            hub.close()


def connect_again(hub: Hub) -> Callable[[], Hub]:
    """Return a function that returns this connection at its first call, then makes new ones to the same address."""
    waiting = [hub]
    return lambda: waiting.pop() if waiting else canwire.connect(hub.address, name=NAME, timed=False)
