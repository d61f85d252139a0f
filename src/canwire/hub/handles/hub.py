"""A program's access to the boards that several programs share."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice
from typing import TYPE_CHECKING

from canwire.boards.description import BoardInfo, board_named
from canwire.hub.handles.channel import HubChannel
from canwire.hub.handles.client import Client
from canwire.hub.handles.control import Control
from canwire.hub.handles.lease import Lease
from canwire.hub.handles.watch import BoardWatch
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.roles import FIFO
from canwire.values.checks import instance, shown
from canwire.values.mistakes.names import answers_wrong_names
from canwire.values.register import RegisterValue

if TYPE_CHECKING:  # each is loaded when it is first opened: few programs want all
    from canwire.boards.can.modes import LineStatus
    from canwire.hub.handles.bus.bus import HubBus, HubLinBus
    from canwire.hub.handles.event import Event
    from canwire.hub.handles.fifo import Fifo
    from canwire.hub.handles.lin import LinControl, Monitor
    from canwire.hub.handles.scheduler import Scheduler
    from canwire.hub.protocol.link import Link


_PAGE = 64  # boards whose lines are requested together: a millisecond of the hub's work


@answers_wrong_names
class Hub(Client):
    """A connection to the owner of the boards, in this process or another; `canwire.connect()` makes one.

    Calls may come from any thread. After the hub is gone every call raises HubLost; connect again then.
    """

    def __init__(self, link: Link) -> None:
        super().__init__(link)
        self._watch = BoardWatch(self)
        self._listen(self._watch.notice)

    def close(self) -> None:
        super().close()
        self._watch.close()

    # boards

    def boards(self) -> tuple[BoardInfo, ...]:
        """All boards that are plugged in, in the order of plugging."""
        page = self.call(m.ListBoards())
        boards: list[BoardInfo] = list(page.boards)
        while page.more:
            page = self.call(m.ListBoards(boards[-1].id))
            boards += page.boards
        return tuple(boards)

    def board(self, name: str) -> BoardInfo:
        """The board with this hardware id, or the first of this kind; NoSuchBoard names all boards."""
        return board_named(self.boards(), name)

    def watch(self, event: Event) -> None:
        """Signal this event at every change of the list of boards."""
        self._watch.assign(event)

    def unwatch(self, event: Event) -> None:
        """Undo `watch`; a second call has no effect."""
        self._watch.unassign(event)

    def plug(
        self,
        kind: str,
        serial: str = "",
        buses: tuple[str, ...] = (),
        *,
        base: int | None = None,
        irq: int | None = None,
        shared_irq: bool = False,
        port: str = "",
        temporary: bool = False,
    ) -> BoardInfo:
        """Plug in a board. By default the hub chooses the `serial` ("HW" and digits), and the kind decides the `buses`.

        An ISA board (inducan104) gets address `base` (default 0x280) and interrupt line `irq` (default 5); InUse
        names a board that already has them. `port` is the place of a real adapter: "/dev/ttyUSB0",
        "socket://host:port" (slcan), "pcan/PCAN_USBBUS1" (python-can). A `temporary` board is pulled out when
        this connection ends in any way.
        """
        board: BoardInfo = self.call(
            m.Plug(kind, serial, buses, base, irq, shared_irq, port, temporary)
        ).board
        return board

    def unplug(self, hardware_id: str) -> None:
        """Pull a board out: all handles on it, of all programs, raise Unplugged from now on."""
        self.call(m.Unplug(hardware_id))

    def open_layer(self, board: int, layer: str) -> Lease:
        """Share an access layer of a board; raises InUse while a program uses another layer."""
        return Lease(self, self.call(m.OpenLayer(board, layer)).handle, f"layer {layer!r} of board {board}")

    # lines

    def obstacle(self, board: BoardInfo, line: int) -> str:
        """Why the CAN line of a real adapter is not on its bus; "" if it is. Always "" for simulated boards."""
        instance("board", board, BoardInfo)
        return self.line_status(board.id, line).obstacle if "Port" in dict(board.resources) else ""

    def line_statuses(self, boards: Iterable[int]) -> dict[tuple[int, int], LineStatus]:
        """The CAN lines of many boards by board and line, in few calls; lines of unplugged boards are left out."""
        pages = (self.call(m.GetLineStatuses(some)) for some in _pages(boards))
        return {(board, line): status for page in pages for board, line, status in page.values}

    def lin_statuses(self, boards: Iterable[int]) -> dict[tuple[int, int], m.LinLineState]:
        """The same for LIN lines."""
        pages = (self.call(m.GetLinStatuses(some)) for some in _pages(boards))
        return {(board, line): state for page in pages for board, line, state in page.values}

    def open_control(self, board: int, line: int, *, kin: str = "") -> Control:
        """The one lease that configures a line, for programs of the interface `kin`; InUse names its holder."""
        _check_line(board, line)
        return Control(self, self.call(m.OpenControl(board, line, kin)).handle, board, line, kin)

    def recover(self, board: int, line: int, *, abort_pending: bool = False) -> None:
        """Return a line from bus-off to the bus, with counters at 0; no effect on a line that is not bus-off.

        A program needs a lease on the line, but not its control; without a lease it gets WrongState. With
        `abort_pending`, all frames queued on the line are discarded first.
        """
        self.call(m.Recover(board, line, abort_pending))

    def open_channel(self, board: int, line: int, *, exclusive: bool = False) -> HubChannel:
        """A channel on a line; an exclusive one has to be the only one, else InUse."""
        _check_line(board, line)
        return HubChannel(self, self.call(m.OpenChannel(board, line, exclusive)).handle, board, line)

    def open_scheduler(self, board: int, line: int, *, kin: str = "") -> Scheduler:
        """The one lease on a line's cyclic list, for programs of the interface `kin`.

        Raises InUse, or Unsupported on a board without one.
        """
        from canwire.hub.handles.scheduler import Scheduler

        return Scheduler(self, self.call(m.OpenScheduler(board, line, kin)).handle, board, line)

    # LIN lines

    def open_lin_control(self, board: int, line: int) -> LinControl:
        """The one lease that configures a LIN line and sends on it; InUse names its holder."""
        from canwire.hub.handles.lin import LinControl

        return LinControl(self, self.call(m.OpenControl(board, line)).handle, board, line)

    def open_monitor(self, board: int, line: int, *, exclusive: bool = False) -> Monitor:
        """A monitor on a LIN line; an exclusive one has to be the only one, else InUse."""
        from canwire.hub.handles.lin import Monitor

        return Monitor(self, self.call(m.OpenMonitor(board, line, exclusive)).handle, board, line)

    def keep_settings(self, board: int, line: int) -> Lease:
        """A lease that keeps the settings of a line, and keeps it running; other programs may use the line."""
        return Lease(self, self.call(m.KeepSettings(board, line)).handle, f"settings of line {line}")

    def open_share(self, board: int, line: int, *, read: bool, write: bool, share: int = 3) -> Lease:
        """Open a line for reading or writing as CreateFile does; `share`: others may read (1), write (2).

        Raises InUse if the share mode of another program forbids it, NoChannel if all channels of the line are in use.
        """
        request = m.OpenShare(board, line, read, write, share)
        return Lease(self, self.call(request).handle, f"share of line {line}")

    # the rest

    def create_fifo(self, capacity: int, element_size: int) -> Fifo:
        """A new FIFO of at least `capacity` elements (1..65535) of `element_size` bytes (1..65535)."""
        from canwire.hub.handles.fifo import Fifo

        reply, descriptors = self.ask(m.CreateFifo(capacity, element_size))
        return Fifo(self, reply, FIFO, descriptors)

    def open_fifo(self, fifo: int, role: str) -> Fifo:
        """Open a FIFO as "fifo", "reader" or "writer"; raises NoSuchBoard, or InUse for an end that is open."""
        from canwire.hub.handles.fifo import Fifo

        reply, descriptors = self.ask(m.OpenFifo(fifo, role))
        return Fifo(self, reply, role, descriptors)

    def create_luid(self) -> int:
        """A number that this hub has not returned before."""
        return int(self.call(m.CreateLuid()).value)

    def hold_interrupts(self, board: int, line: int, held: bool = True) -> None:
        """A fault: with `held`, stop the line's driver from serving its chip, which then overruns; else end this."""
        self.call(m.HoldInterrupts(board, line, held))

    def bus(self, name: str) -> HubBus:
        """A CAN bus by its name; raises NoSuchBoard, or Unsupported for a LIN bus and for a real adapter's."""
        from canwire.hub.handles.bus.bus import HubBus

        return HubBus(self, name)

    def lin_bus(self, name: str) -> HubLinBus:
        """A LIN bus by its name; raises NoSuchBoard, or Unsupported for a CAN bus."""
        from canwire.hub.handles.bus.bus import HubLinBus

        return HubLinBus(self, name)

    def short(self, bus: str, shorted: bool = True) -> None:
        """Short the wires of a bus, or remove this short; raises NoSuchBoard. The short outlives this connection."""
        self.call(m.Disturb(bus, shorted))

    def registers(self, board: int, line: int) -> tuple[RegisterValue, ...]:
        """The registers of the line's chip, read without side effects; none for an ideal controller."""
        values: tuple[RegisterValue, ...] = self.call(m.GetRegisters(board, line)).values
        return values

    def note(self, name: str) -> bytes:
        """The note that a program has left at the hub under this name; b"" if none."""
        return bytes(self.call(m.GetNote(name)).value)

    def notes(self, prefix: str) -> dict[str, bytes]:
        """All notes whose names begin with `prefix`."""
        return dict(self.call(m.ListNotes(prefix)).values)

    def set_note(self, name: str, value: bytes, *, leaves: bool = False) -> None:
        """Leave a note for other programs, and replace an earlier one; b"" removes it.

        A note that `leaves` is removed when this program ends.
        """
        self.call(m.SetNote(name, value, leaves))


def _pages(boards: Iterable[int]) -> Iterator[tuple[int, ...]]:
    left = iter(dict.fromkeys(boards))
    while page := tuple(islice(left, _PAGE)):
        yield page


def _check_line(board: object, line: object) -> None:
    """Raise TypeError, naming the way from names to numbers, for what are no numbers of a board and its line."""
    for name, number in (("board", board), ("line", line)):
        if not isinstance(number, int):
            raise TypeError(
                f"{name} {shown(number)}: must be int, not {type(number).__name__}; "
                "place = canwire.find_lines(hub, name)[0] has place.board.id and place.line"
            )
