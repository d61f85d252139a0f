"""Serves the CAN sockets of one `canwire run`, until the program has ended and all sockets are closed."""

from __future__ import annotations

import errno
import os
import struct
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

from canwire import Event
from canwire.socketcan.boards.boards import Boards
from canwire.socketcan.interfaces import Interfaces
from canwire.socketcan.loop import READABLE, URGENT, Loop
from canwire.socketcan.netlink.door import NetlinkDoor
from canwire.socketcan.netlink.files import NetFiles
from canwire.socketcan.netlink.links import Links
from canwire.socketcan.netlink.proc_files import ProcFiles
from canwire.socketcan.ports import Ports, refuse
from canwire.socketcan.programs import calls_itself, is_for_musl, trouble_with
from canwire.socketcan.requests.control import Asked, Control, Request
from canwire.socketcan.requests.operations import TAKING_PART, Operation, do_with_socket
from canwire.socketcan.rings import Rings
from canwire.socketcan.setting import Setting
from canwire.socketcan.sockets.open_sockets import OpenSockets
from canwire.socketcan.supervised.notices import Listener, fetched
from canwire.socketcan.supervised.supervisor import Supervisor
from canwire.socketcan.table import Table
from canwire.socketcan.timed.timers import TimerSignal
from canwire.socketcan.timed.turns import TimedWaiter
from canwire.socketcan.wire import numpy_module

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire import Hub, WantedMode

NOTE_PROTOCOL, NOTE_NETLINK, NOTE_EXEC, NOTE_CLOCK, NOTE_NOT_SUPERVISED = range(1, 6)
_FLUSH_S = 1.2  # without a frame going out, after which the rest is given up
_LOOK_S = 0.02
_UNTIL, _TIMER = struct.Struct("<q"), struct.Struct("<qq")


def _times(layout: struct.Struct, request: Request) -> tuple[int, ...]:
    """The times in a request's data; raises OSError if its size is wrong."""
    if len(request.data) != layout.size:
        raise refuse(errno.EINVAL)
    return layout.unpack(request.data)


class Left(NamedTuple):
    """The amount that is still to be sent after the programs have ended."""

    pending: int
    sockets: int
    progress: int


class Server:
    """`directory` gets the table, the rings and the socket of requests; `library` is the shim.

    `say` shows one line to the user.
    """

    def __init__(
        self,
        hub: Hub,
        directory: str,
        library: str,
        mappings: dict[str, str],
        wanted: WantedMode,
        epoch_ns: int,
        say: Callable[[str], object],
    ) -> None:
        boards = Event()
        hub.watch(boards)  # before the list of boards is read: later boards are reported
        prefix = f"canwire-{os.urandom(3).hex()}-"
        table = Table(os.path.join(directory, "table"), prefix.encode())
        self._turns = TimedWaiter(hub, table) if hub.timed else None
        self._loop = Loop()
        if self._turns is not None:
            table.keep_time(epoch_ns)
            self._loop = self._turns.loop = Loop(self._turns, self._turns.clock_s)
        interfaces = Interfaces(hub, table, mappings)
        self._setting = Setting(hub, self._loop, table, interfaces, wanted, epoch_ns, say)
        self._setting.deserted = self._stop_if_unused
        if self._turns is not None:
            self._setting.stir = self._turns.stir
        self._ports = Ports(self._setting)
        self._said: set[str] = set()
        rings = Rings(os.path.join(directory, "rings"), library)
        self._sockets = OpenSockets(
            self._setting, self._ports, rings, prefix, self._stop_if_unused, self._say_once
        )
        self._setting.came_up = self._look_again
        self._boards = Boards(self._setting, self._ports, boards, self._look_again, self._say_once)
        self._alive: set[int] = set()
        self._control = Control(
            self._loop, os.path.join(directory, "control"), self._answer, self._setting.fault
        )
        self._netlink: NetlinkDoor | None = None
        links = Links(self._setting, self._ports)
        proc = ProcFiles(os.path.join(directory, "proc"), links, self._ports, self._sockets)
        self._files = (NetFiles(os.path.join(directory, "net"), links), proc)  # shim/shim.h, enum folder
        with suppress(OSError):  # a kernel that gives none: programs have its own alone, and that is said
            self._netlink = NetlinkDoor(self._setting, links)

    def run(self, programs: tuple[int, int]) -> None:
        """Serve until all of these descriptors are readable or hung up, and no program has a socket any more."""
        self._loop.soon(numpy_module)  # loads while the program starts
        self._alive = set(programs)
        for descriptor in programs:
            self._watch_end(descriptor)
        self._loop.run()
        self._flush()
        self.close()

    def close(self) -> None:
        for one in self._sockets:
            one.close()
        self._control.close()
        if self._netlink is not None:
            self._netlink.close()
        self._ports.close()
        self._boards.close()
        self._setting.table.close()
        self._loop.close()

    # the end

    def _watch_end(self, descriptor: int) -> None:
        def ended(_: int) -> None:
            self._loop.forget(descriptor)
            self._alive.discard(descriptor)
            if self._turns is not None and not self._alive:
                self._turns.ended = True
            self._stop_if_unused()

        self._loop.watch(descriptor, READABLE | URGENT, ended)

    def _stop_if_unused(self) -> None:
        if not self._alive and all(one.deserted for one in self._sockets):
            self._loop.stop()

    def _flush(self) -> None:
        """Wait until waiting frames are sent, or make no progress."""
        self._setting.deserted = lambda: None
        state, since_s = self._left(), self._loop.clock_s()

        def look() -> None:
            nonlocal state, since_s
            now, now_s = self._left(), self._loop.clock_s()
            if now != state:
                state, since_s = now, now_s
            if not (now.pending or now.sockets) or now_s - since_s > _FLUSH_S:
                self._loop.stop()
            else:
                self._loop.call_in(_LOOK_S, look)

        self._alive = {-1}  # from here on `look` stops the loop
        self._loop.soon(look)
        self._loop.run()
        for loss in self._setting.interfaces.losses():
            self._setting.say(loss)
        if state.pending:
            self._say_once("frames were not sent: no node acknowledges them, or the line is not on its bus")

    def _left(self) -> Left:
        return Left(self._ports.pending(), len(self._sockets), self._ports.progress())

    def _look_again(self) -> None:
        for one in self._sockets:
            one.boards_changed()

    # requests

    def _answer(self, request: Request, asked: Asked) -> None:
        if self._turns is None:
            self._do(request, asked)
        else:
            self._answer_in_time(self._turns, request, asked)

    def _answer_in_time(self, turns: TimedWaiter, request: Request, asked: Asked) -> None:
        """Answer where programs share one time: a program that asks runs until it waits or its answer comes later."""
        if request.operation == Operation.LEAVE_TIME:
            turns.leaves(request)
            asked.answer(0)
            return
        takes_part = request.operation in TAKING_PART
        if request.operation == Operation.TAKE_PART and request.a:
            takes_part = turns.has_seat(request.a)
        turns.requested(request, asked, takes_part=takes_part)
        if request.operation == Operation.AWAIT_TURN:
            turns.waits(request, asked, *_times(_UNTIL, request))
        elif request.operation == Operation.SET_TIMER:
            before = turns.set_timer(request.process, *_times(_TIMER, request))
            asked.answer(0, _TIMER.pack(*before))
        elif request.operation == Operation.TAKE_PART:
            asked.answer(0 if takes_part else 1)
        elif request.operation == Operation.OPEN_TIMER:
            value = _times(_UNTIL, request)[0] if request.data else 0
            signal = TimerSignal(request.b, value, request.slot)
            number, descriptor = turns.timers.open(request.process, bool(request.a), signal)
            asked.answer(number, descriptor=descriptor)
        elif request.operation == Operation.SET_TIMER_FD:
            times = _times(_TIMER, request) if request.a else None
            asked.answer(0, _TIMER.pack(*turns.timers.set(request.slot, times)))
        else:
            self._do(request, asked)
            turns.still_asks(request, asked)

    def _do(self, request: Request, asked: Asked) -> None:
        if request.operation == Operation.OPEN_SOCKET:
            self._open(request, asked)
            return
        if request.operation == Operation.NOTE:
            asked.answer(self._note(request))
            return
        if request.operation == Operation.PLACE_FILES:
            if not 0 <= request.a < len(self._files):
                raise refuse(errno.EINVAL)
            self._files[request.a].refresh(os.fsdecode(request.data))
            asked.answer(0)
            return
        if request.operation == Operation.SUBSCRIBE and self._netlink is not None:
            self._netlink.subscribe(request.a, request.b)
            asked.answer(0)
            return
        if request.operation == Operation.SUPERVISE:
            self._supervise(request, asked)
            return
        found = self._sockets.of_slot(request.slot)
        if found is None:
            raise refuse(errno.EBADF)
        do_with_socket(found, request, asked)

    def _open(self, request: Request, asked: Asked) -> None:
        with self._sockets.make(request.a, request.b, request.program) as theirs:
            asked.answer(0, descriptor=theirs.fileno())

    def _supervise(self, request: Request, asked: Asked) -> None:
        """Answer the calls of the process that asks, and of what it starts, from now on."""
        descriptor = fetched(request.process, request.a)
        if request.b:  # it asks only whether that is allowed
            os.close(descriptor)
            asked.answer(0)
            return
        listener = Listener(descriptor)
        if self._turns is not None:
            self._say_once(f"{request.program} preloads nothing: it has CAN, and its own time")
        Supervisor(self._setting, self._sockets, listener, self._netlink)
        asked.answer(0)

    def _note(self, request: Request) -> int:
        """1: its calls are to be answered, see supervised/; 2: and nothing is to be preloaded."""
        if request.a == NOTE_NETLINK:
            self._say_once(
                f"{request.program} opened a netlink socket, which finds the kernel's interfaces alone: "
                "this kernel has no NETLINK_USERSOCK"
            )
        elif request.a == NOTE_CLOCK:
            self._say_once(
                f"{request.program} uses {os.fsdecode(request.data)}: by the computer's clock, not by the hub's time"
            )
        elif request.a == NOTE_EXEC:
            path = os.fsdecode(request.data)
            if calls_itself(path):
                return 2 if is_for_musl(path) else 1
            if trouble := trouble_with(path):
                self._say_once(f"{path} {trouble}; it has no CAN")
        elif request.a == NOTE_NOT_SUPERVISED:
            why = os.fsdecode(request.data)
            self._say_once(f"{request.program} starts a program that preloads nothing ({why}): it has no CAN")
        return 0

    def _say_once(self, what: str) -> None:
        if what not in self._said:
            self._said.add(what)
            self._setting.say(what)
