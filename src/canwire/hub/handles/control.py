"""The right to configure a CAN line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.boards.can.modes import LineMode, LineStatus
from canwire.hub.handles.filtered import Filtered
from canwire.hub.protocol import messages as m
from canwire.values.checks import instance
from canwire.values.mistakes.names import answers_wrong_names

if TYPE_CHECKING:
    from canwire.hub.handles.client import Client
    from canwire.values.timing.bit_timing import BitTiming


@answers_wrong_names
class Control(Filtered):
    """The one lease that may configure a line."""

    def __init__(self, hub: Client, handle: int, board: int, line: int, kin: str = "") -> None:
        super().__init__(hub, handle, f"control of line {line}")
        self.kin = kin
        self.board = board
        self.line = line

    def initialise(self, mode: LineMode) -> None:
        """Reset the line and set it up; it is stopped then. Raises NothingHeard if it had to find its bit rate."""
        instance("mode", mode, LineMode)
        self.ask(m.Initialise(self._handle, mode))

    def start(self, *, abort_pending: bool = False) -> None:
        """Take part in the bus; with `abort_pending`, discard the frames queued by all channels before."""
        self.ask(m.Start(self._handle, abort_pending))

    def stop(self) -> None:
        """Leave the bus once a frame on the wire is over."""
        self.ask(m.Stop(self._handle))

    def reset(self) -> None:
        """Leave the bus immediately, even within a frame, and discard settings and filters."""
        self.ask(m.Reset(self._handle))

    def detect(
        self,
        candidates: list[tuple[BitTiming, BitTiming | None]],
        timeout_ms: int,
        *,
        iso_fd: bool = True,
        low_speed: bool = False,
    ) -> int:
        """The index of the candidate that is the rate of the bus; only listens. Raises NothingHeard."""
        request = m.Detect(self._handle, tuple(candidates), timeout_ms, iso_fd, low_speed)
        return int(self.ask(request).value)

    def sleep(self) -> None:
        """Save power until the bus is active or a frame is to be sent; raises Unsupported."""
        self.ask(m.Sleep(self._handle, True))

    def wake(self) -> None:
        self.ask(m.Sleep(self._handle, False))

    def read_register(self, address: int, *, reset_mode: bool = False) -> int:
        """Read one register of the line's chip, with the side effects of that; Unsupported for an ideal controller."""
        return int(self.ask(m.ReadRegister(self._handle, address, reset_mode)).value)

    def write_register(self, address: int, value: int, *, reset_mode: bool = False) -> None:
        """Write one register, with all effects; for `reset_mode` the line leaves its bus for a moment."""
        self.ask(m.WriteRegister(self._handle, address, value, reset_mode))

    def annotate(self, note: bytes) -> None:
        """Replace the note in the line's mode; every channel gets a CHANGED event. The controller is not affected."""
        self.ask(m.Annotate(self._handle, note))

    def status(self) -> LineStatus:
        self.check()
        return self.hub.line_status(self.board, self.line, kin=self.kin)
