"""Which interfaces there are, while boards come and go, and while the hub does.

While the hub is away its interfaces are down: sockets stay bound, and receive again once the hub is back. Frames that
were to be sent before are dropped and counted.
"""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from canwire import CanwireError, Event, HubError, NoSuchBoard, Unplugged, epoch_ns
from canwire.socketcan.boards.connecting import Connecting
from canwire.socketcan.loop import READABLE
from canwire.socketcan.table import MOST_INTERFACES, UP

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire import Hub
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.ports import Ports
    from canwire.socketcan.setting import Setting

_AGAIN_S = 1.0  # before an interface whose line cannot be opened yet is tried again


class Boards:
    """`event` is one that the hub signals at changes. `look` lets all sockets look again.

    A hub in lockstep does not come back, since its time begins again.
    """

    def __init__(
        self,
        setting: Setting,
        ports: Ports,
        event: Event,
        look: Callable[[], object],
        say_once: Callable[[str], object],
    ) -> None:
        self._setting = setting
        self._ports = ports
        self._event = event
        self._look = look
        self._say_once = say_once
        self._first = setting.hub
        self._back: list[Hub] = []
        self._found = Event()
        self._connecting = Connecting(setting.hub.address, self._is_back)
        setting.comes_back = bool(setting.hub.address) and not setting.timed
        setting.hub_gone = self._hub_gone
        setting.loop.watch(event.fileno(), READABLE, self._changed)
        setting.loop.watch(self._found.fileno(), READABLE, self._use)
        self._say_what_is_unplaced()

    def close(self) -> None:
        """Close the event and a hub that came back."""
        self._connecting.stop()
        self._event.close()
        self._found.close()
        if self._setting.hub is not self._first:
            self._setting.hub.close()

    def _changed(self, _: int) -> None:
        self._event.wait(0)
        try:
            self._refresh()
        except HubError:  # the ports say what there is to say
            if self._setting.hub.lost and self._setting.comes_back:
                self._hub_gone()
            return
        self._look()

    def _refresh(self) -> None:
        gone = self._setting.interfaces.refresh()
        self._say_what_is_unplaced()
        for interface in gone:
            if self._ports.known(interface.index) is None:
                self._setting.interfaces.remove(interface)

    def _say_what_is_unplaced(self) -> None:
        if names := sorted(self._setting.interfaces.unplaced):
            self._say_once(
                f"{MOST_INTERFACES} interfaces are all there can be: {names[0]} and {len(names) - 1} more are none"
            )

    # the hub

    def _hub_gone(self) -> None:
        """All interfaces are down until the hub is back; a second call has no effect."""
        if self._connecting.lasts:
            return
        for interface in self._every():
            self._setting.interfaces.take_down(interface)
        self._setting.say("the hub is gone; its interfaces are down until it is back")
        self._connecting.begin()

    def _is_back(self, hub: Hub) -> None:
        self._back.append(hub)
        self._found.set()

    def _use(self, _: int) -> None:
        self._found.wait(0)
        setting, hub = self._setting, self._back.pop()
        if setting.hub is not self._first:
            setting.hub.close()
        with suppress(HubError):  # it is gone again, which the next event reports
            hub.watch(self._event)
            setting.epoch_ns = epoch_ns(hub)
        setting.hub = setting.interfaces.hub = hub
        away_s = self._connecting.end()
        try:
            self._refresh()
        except HubError:
            self._hub_gone()
            return
        self._bring_up()
        setting.say(f"the hub is back; the {away_s:.1f} s before were missed")

    def _bring_up(self) -> None:
        """Bring up the interfaces that were up; try again later where that fails."""
        left = [interface for interface in self._every() if interface.returns and not self._is_up(interface)]
        self._look()
        if left and not self._connecting.lasts:
            self._setting.loop.call_in(_AGAIN_S, self._bring_up)

    def _is_up(self, interface: Interface) -> bool:
        port = self._ports.known(interface.index)
        if port is None:
            self._setting.interfaces.show(interface, UP)
        else:
            try:
                port.open_again()
            except (NoSuchBoard, Unplugged):
                port.vanish()
            except CanwireError as error:
                self._say_once(f"{interface.name}: {error}")
                return False
        interface.returns = False
        return True

    def _every(self) -> list[Interface]:
        return list(self._setting.interfaces.by_index.values())
