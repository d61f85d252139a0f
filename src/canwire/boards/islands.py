"""Lines that are disconnected: each is alone on a private stub bus, as on a cable whose plug was pulled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from canwire.timeline import Source, Timeline

LineT = TypeVar("LineT")
WireT = TypeVar("WireT", bound=Source)


class Islands(Generic[LineT, WireT]):
    """The stub buses, by line. `stub` makes one; `plug` puts a line on a bus, `unplug` removes it from its bus."""

    def __init__(
        self,
        timeline: Timeline,
        stub: Callable[[Timeline, str], WireT],
        plug: Callable[[LineT, WireT], None],
        unplug: Callable[[LineT], None],
    ) -> None:
        self._timeline = timeline
        self._stub = stub
        self._plug = plug
        self._unplug = unplug
        self._stubs: dict[LineT, WireT] = {}

    def stubs(self) -> list[WireT]:
        return list(self._stubs.values())

    def pull(self, line: LineT, name: str) -> WireT:
        """Disconnect a line now, even in the middle of a frame; returns the stub.

        Does nothing if it is disconnected already.
        """
        if line not in self._stubs:
            self._unplug(line)
            stub = self._stubs[line] = self._stub(self._timeline, f"{name} (disconnected)")
            self._plug(line, stub)
        return self._stubs[line]

    def put_back(self, line: LineT, go_home: Callable[[LineT], None]) -> None:
        """Reconnect a line with `go_home`, which plugs it into its bus again; does nothing if it is not
        disconnected.
        """
        if line in self._stubs:
            self._unplug(line)
            self._timeline.remove(self._stubs.pop(line))
            go_home(line)
