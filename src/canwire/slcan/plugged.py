"""A dongle together with its board at the hub."""

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
    """A dongle on a board that it plugs in on this bus; `close` pulls the board out. Run the dongle in a Service.

    Raises NoSuchBoard.
    """

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
        """Pull the board out at any time; a second call has no effect."""
        with suppress(HubError):
            self._hub.unplug(self.board.hardware_id)
        if self._port is not None:
            with suppress(HubError):
                self._port.end()
