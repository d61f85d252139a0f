"""What a client holds at its hub: leases that are given back when closed, or when the client is gone."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from canwire.boards.can.modes import CyclicStatus, LineMode, LineStatus
from canwire.errors import Closed, HubLost
from canwire.hub.protocol import messages as m

if TYPE_CHECKING:
    from types import TracebackType

    from canwire.hub.handles.hub import Hub
    from canwire.values.timing.bit_timing import BitTiming

Self = TypeVar("Self", bound="Lease")


class Lease:
    """Something held at the hub. Closing twice is fine; used after that it raises Closed.

    Once its board is pulled out every use raises Unplugged, once the hub is gone HubLost.
    """

    def __init__(self, hub: Hub, handle: int, name: str) -> None:
        self.hub = hub
        self.name = name
        self._handle = handle
        self._closed = False
        self._gone: Exception | None = None
        hub.adopt(self)

    @property
    def handle(self) -> int:
        return self._handle

    def check(self) -> None:
        """Raise what keeps this from being used, if anything does."""
        if self._closed:
            raise Closed(self.name)
        if self._gone is not None:
            raise self._gone
        if self.hub.lost:
            raise HubLost(f"{self.name}: the hub is gone")

    @property
    def over(self) -> bool:
        """Nothing more will happen on this lease."""
        return self._closed or self._gone is not None or self.hub.lost

    def end(self, why: Exception) -> None:
        """For the hub: the other side has ended this lease; whoever waits on it wakes up."""
        if self._gone is None:
            self._gone = why

    def close(self) -> None:
        if not self._closed:
            over, self._closed = self.over, True
            self.hub.forget(self)
            if not over:
                with contextlib.suppress(HubLost):  # then it is given back already
                    self.hub.call(m.Close(self._handle))

    def __enter__(self: Self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def ask(self, request: m.Message) -> Any:
        """Ask the hub about this lease."""
        self.check()
        return self.hub.call(request)


class Filtered(Lease):
    """A control or a channel: both have a filter for 11-bit and one for 29-bit frames, of two stages each.

    Code and mask are VCI's: id << 1 | remote, a mask bit of 1 compares (VCI V4 manual 5.2.4). Filters change
    only while the line is stopped or the channel inactive, else WrongState.
    """

    def filter_mode(self, *, extended: bool) -> int:
        """FilterMode now."""
        return int(self.ask(m.GetFilterMode(self._handle, extended)).value)

    def set_filter_mode(self, mode: int, *, extended: bool) -> int:
        """Returns the mode before."""
        return int(self.ask(m.SetFilterMode(self._handle, extended, mode)).value)

    def set_acceptance(self, code: int, mask: int, *, extended: bool) -> None:
        """The first stage: one bit pattern."""
        self.ask(m.SetAcceptanceFilter(self._handle, extended, code, mask))

    def add_ids(self, code: int, mask: int, *, extended: bool) -> None:
        """The second stage: put every identifier that agrees with the pattern on the list."""
        self.ask(m.ListIds(self._handle, extended, code, mask, True))

    def remove_ids(self, code: int, mask: int, *, extended: bool) -> None:
        """Take them off the list."""
        self.ask(m.ListIds(self._handle, extended, code, mask, False))


class Control(Filtered):
    """The one lease that may configure a line."""

    def __init__(self, hub: Hub, handle: int, board: int, line: int) -> None:
        super().__init__(hub, handle, f"control of line {line}")
        self.board = board
        self.line = line

    def initialise(self, mode: LineMode) -> None:
        """Reset the line and set it up; it is stopped then. Raises NothingHeard if it had to find its bit rate."""
        self.ask(m.Initialise(self._handle, mode))

    def start(self, *, abort_pending: bool = False) -> None:
        """Take part in the bus; with `abort_pending` everything that any channel has queued is given up before."""
        self.ask(m.Start(self._handle, abort_pending))

    def stop(self) -> None:
        """Leave the bus once a frame on the wire is over."""
        self.ask(m.Stop(self._handle))

    def reset(self) -> None:
        """Leave the bus at once, mid-frame if need be, and forget settings and filters."""
        self.ask(m.Reset(self._handle))

    def detect(
        self,
        candidates: list[tuple[BitTiming, BitTiming | None]],
        timeout_ms: int,
        *,
        iso_fd: bool = True,
        low_speed: bool = False,
    ) -> int:
        """The place of the rate that the bus speaks; only listens. Raises NothingHeard."""
        request = m.Detect(self._handle, tuple(candidates), timeout_ms, iso_fd, low_speed)
        return int(self.ask(request).value)

    def sleep(self) -> None:
        """Save power until something happens on the bus, or is to be sent; raises Unsupported."""
        self.ask(m.Sleep(self._handle, True))

    def wake(self) -> None:
        self.ask(m.Sleep(self._handle, False))

    def read_register(self, address: int, *, reset_mode: bool = False) -> int:
        """One register of the line's chip, with what reading it does; raises Unsupported for an ideal one."""
        return int(self.ask(m.ReadRegister(self._handle, address, reset_mode)).value)

    def write_register(self, address: int, value: int, *, reset_mode: bool = False) -> None:
        """Write one, whatever that does; in `reset_mode` the line leaves its bus for a moment."""
        self.ask(m.WriteRegister(self._handle, address, value, reset_mode))

    def status(self) -> LineStatus:
        self.check()
        return self.hub.line_status(self.board, self.line)


class Scheduler(Lease):
    """The one lease on a line's cyclic transmit list: boards/can/scheduler.py's."""

    def __init__(self, hub: Hub, handle: int, board: int, line: int) -> None:
        super().__init__(hub, handle, f"cyclic list of line {line}")
        self.board = board
        self.line = line

    def add(
        self,
        record: bytes,
        cycle: int,
        *,
        increment: int = 0,
        byte_index: int = 0,
        owner: Lease | None = None,
    ) -> int:
        """Index of the new object. `record` is its frame (values/record.py), request bits included; cycle in ticks.

        To the channel `owner` of this hub connection its frames are its own.
        """
        channel = 0 if owner is None else owner.handle
        return int(self.ask(m.AddCyclic(self._handle, record, cycle, increment, byte_index, channel)).value)

    def replace(self, index: int, record: bytes) -> None:
        """Another frame, in the same ticks; not for one that grows."""
        self.ask(m.ReplaceCyclic(self._handle, index, record))

    def remove(self, index: int) -> None:
        self.ask(m.RemoveCyclic(self._handle, index))

    def start(self, index: int, count: int = 0) -> None:
        """`count` times, 0: for ever."""
        self.ask(m.StartCyclic(self._handle, index, count))

    def start_in_turn(self, indices: Sequence[int], counts: Sequence[int], step: int) -> None:
        """The first one in the next tick, the others each `step` ticks later; a count of 0: for ever.

        Raises WrongState for a list that does not run.
        """
        self.ask(m.StartInTurn(self._handle, tuple(indices), tuple(counts), step))

    def stop(self, index: int) -> None:
        self.ask(m.StopCyclic(self._handle, index))

    def resume(self) -> None:
        self.ask(m.RunScheduler(self._handle, True))

    def suspend(self) -> None:
        self.ask(m.RunScheduler(self._handle, False))

    def reset(self) -> None:
        self.ask(m.ResetScheduler(self._handle))

    def status(self) -> CyclicStatus:
        status: CyclicStatus = self.ask(m.GetSchedulerStatus(self._handle)).status
        return status
