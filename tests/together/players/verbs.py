"""`canwire dump` and `send` on one line, `stop` and `recover`: what the verbs do once they have a hub."""

from __future__ import annotations

from typing import Any

import canwire
from canwire import BusEvent, ChannelMode, EventKind, Frame, LinePlace, Siblings, WantedMode
from canwire.commands.can_line import bring_up
from canwire.commands.devices.verb import line_cells
from canwire.commands.recover import recover
from canwire.commands.stop import stop
from tests.together.players.player import RATE, Player

EVENTS = tuple(int(kind) for kind in (EventKind.ERROR, EventKind.STATE))


class Verbs(Player):
    """A failure is the one line on stderr; its class tells which."""

    kind = "canwire dump/send"

    def __init__(self, hub: canwire.Hub, board: canwire.BoardInfo) -> None:
        super().__init__(hub, board)
        self._place = LinePlace(board, 0)
        self._channel: Any = None

    def join(self) -> str:
        return self.tell(lambda: self._open(WantedMode()))

    def set_up(self) -> str:
        return self.tell(lambda: self._open(WantedMode(RATE)))

    def _open(self, wanted: WantedMode) -> None:
        channel = self.hub.open_channel(self.board.id, 0)
        try:
            channel.set_up(ChannelMode(200, 200, siblings=Siblings.EVERY, events=EVENTS))
            bring_up(self.hub, self._place, wanted)
            channel.activate()
        except BaseException:
            channel.close()
            raise
        self._channel = channel

    def set_rate(self, rate: int) -> str:
        return self.tell(lambda: bring_up(self.hub, self._place, WantedMode(rate)))

    def stop(self) -> str:
        return self.tell(lambda: stop(self.hub, self._place))

    def reset(self) -> str:
        return self.tell(lambda: stop(self.hub, self._place, reset=True))

    def recover(self) -> str:
        return self.tell(lambda: recover(self.hub, self._place))

    def send(self, identifier: int) -> str:
        return self.tell(lambda: self._channel.send(Frame(identifier)))

    def received(self) -> list[int]:
        return [one.id for one in self._waiting() if isinstance(one, Frame)]

    def told(self) -> set[str]:
        return {EventKind(one.kind).name for one in self._waiting() if not isinstance(one, Frame)}

    def _waiting(self) -> list[Frame | BusEvent]:
        found = []
        while (one := self._channel.receive_any()) is not None:
            found.append(one)
        return found

    def state(self) -> str:
        """What `canwire devices` shows."""

        def look() -> str:
            status = self._place.status(self.hub)
            return line_cells(0, self._place.info, status)[3]

        return self.tell(look)

    def end(self) -> None:
        self.hub.close()
