"""A dongle and the board of the hub that it is made of."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from canwire import HubError
from canwire.slcan.dongle import Dongle
from canwire.slcan.eeprom import Eeprom
from canwire.slcan.hub_port import HubPort, plug_dongle
from canwire.slcan.settings import Settings

if TYPE_CHECKING:
    from canwire import Event, Hub


class PluggedDongle:
    """Plugs in a board for it on this bus, and pulls it out by `close`; a Service makes it work. Raises NoSuchBoard."""

    def __init__(
        self, hub: Hub, settings: Settings | None = None, bus: str = "can0", eeprom: Eeprom | None = None
    ) -> None:
        settings = settings or Settings()
        self._hub = hub
        self.board = plug_dongle(hub, settings.dialect, bus)
        self._port: HubPort | None = None
        try:
            self._port = HubPort(hub, self.board)
            self.dongle = Dongle(self._port, self._port.now_ns, settings, eeprom)
        except BaseException:
            self.close()
            raise

    @property
    def event(self) -> Event:
        """Signalled when the dongle has something to `pump`."""
        assert self._port is not None
        return self._port.event

    def close(self) -> None:
        """Pull it out, whatever it is doing; a second time does nothing."""
        with suppress(HubError):
            self._hub.unplug(self.board.hardware_id)
        if self._port is not None:
            with suppress(HubError):
                self._port.end()
