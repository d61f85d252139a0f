"""The server's interfaces as links: the data that `ip link` shows, and the settings that it may change.

A line is set up and started as by `canwire up`, and keeps running when the program has ended; "down" stops it for all
programs, as `canwire stop` does.
"""

from __future__ import annotations

import errno
import struct
from dataclasses import replace
from typing import TYPE_CHECKING

from canwire import (
    CanwireError,
    ErrorState,
    InUse,
    LinePlace,
    LineStatus,
    find_lines,
    format_rates,
    format_setter,
    start_line,
)
from canwire.socketcan.netlink import controller
from canwire.socketcan.netlink.messages import attribute, attributes_in
from canwire.socketcan.ports import Ports
from canwire.socketcan.table import OFF, UP

if TYPE_CHECKING:
    from collections.abc import Sequence

    from canwire import Hub, LineMode, WantedMode
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.setting import Setting

INFO = struct.Struct("<BxHiII")  # struct ifinfomsg: family, type, index, flags, change
_NAME, _MTU, _QDISC, _STATS, _QUEUE, _OPERATING, _LINK_MODE, _LINK_INFO = 3, 4, 6, 7, 13, 16, 17, 18
_STATS64, _GROUP, _PROMISCUITY, _SEND_QUEUES, _RECEIVE_QUEUES, _CARRIER, _ALT_NAME = (
    23,
    27,
    30,
    31,
    32,
    33,
    53,
)
_INFO_KIND, _INFO_DATA, _INFO_XSTATS = 1, 2, 3
_FLAG_UP, _FLAG_RUNNING, _NO_ARP, _LOWER_UP, _ECHO = 0x1, 0x40, 0x80, 0x10000, 0x40000
TYPE_CAN = 280  # ARPHRD_CAN
_DOWN, _OPERATES = 2, 6  # IF_OPER_
QUEUE_LENGTH = 1000
COUNTS = (  # of struct rtnl_link_stats64, in its order
    *(
        "rx_packets",
        "tx_packets",
        "rx_bytes",
        "tx_bytes",
        "rx_errors",
        "tx_errors",
        "rx_dropped",
        "tx_dropped",
    ),
    *("multicast", "collisions", "rx_length_errors", "rx_over_errors", "rx_crc_errors", "rx_frame_errors"),
    *("rx_fifo_errors", "rx_missed_errors", "tx_aborted_errors", "tx_carrier_errors", "tx_fifo_errors"),
    *("tx_heartbeat_errors", "tx_window_errors", "rx_compressed", "tx_compressed"),
)
_NEEDS_DOWN = "the line runs; take it down before it is set up otherwise"


_AWAY = LineStatus(  # of lines whose hub is away
    initialised=False,
    running=False,
    mode=None,
    state=ErrorState.STOPPED,
    tec=0,
    rec=0,
    last_error=0,
    load=0.0,
    transmitting=False,
    coupling_fault=False,
    frames_sent=0,
    frames_received=0,
    errors=0,
    arbitration_losses=0,
    refused=0,
    lost=0,
    control_holder="",
    scheduler_holder="",
    channels=0,
    exclusive=False,
    time_ns=0,
)


class Refused(Exception):
    """The errno with which a program's request fails, and the reason."""

    def __init__(self, error: int, why: str = "") -> None:
        super().__init__(error, why)
        self.error = error
        self.why = why


def link_request(
    interface: Interface, *, up: bool | None = None, data: Sequence[tuple[int, bytes]] = ()
) -> bytes:
    """The body of an RTM_SETLINK that takes it up or down (None: neither), with these IFLA_CAN_ attributes."""
    head = INFO.pack(0, TYPE_CAN, interface.index, _FLAG_UP if up else 0, 0 if up is None else _FLAG_UP)
    content = b"".join(attribute(kind, value) for kind, value in data)
    return head + (attribute(_LINK_INFO, attribute(_INFO_DATA, content)) if content else b"")


class Links:
    """The links of one server."""

    def __init__(self, setting: Setting, ports: Ports) -> None:
        self._setting = setting
        self._ports = ports

    @property
    def all(self) -> list[Interface]:
        return list(self._setting.interfaces.by_index.values())

    def meant(self, body: bytes) -> Interface | None:
        """The interface of a request, by index or name; None if it is not the server's."""
        if len(body) < INFO.size:
            return None
        index, attributes = INFO.unpack_from(body)[2], attributes_in(body[INFO.size :])
        if index > 0:
            return self._setting.interfaces.by_index.get(index)
        name = attributes.get(_NAME, attributes.get(_ALT_NAME, b"")).split(b"\0", 1)[0].decode("latin-1")
        return next((one for one in self.all if one.name == name), None)

    def gone(self, interface: Interface) -> bytes:
        """The body of an RTM_DELLINK."""
        name = attribute(_NAME, interface.name.encode() + b"\0")
        return INFO.pack(0, TYPE_CAN, interface.index, _NO_ARP | _ECHO, 0) + name

    # shown

    def link(self, interface: Interface) -> bytes:
        """The body of an RTM_NEWLINK. Raises CanwireError."""
        place, mode, status = self._line_of(interface)
        up = bool(interface.flags & UP)
        flags, runs = _flags(interface)
        state = ErrorState(status.state) if status.running else ErrorState.STOPPED
        if up and not status.running:  # it starts when a socket is bound to it
            state = ErrorState.ERROR_ACTIVE
        word = struct.Struct("<I").pack
        data = controller.shown(place.info.capabilities, mode, status, state, interface.restart_ms)
        info = attribute(_INFO_KIND, b"can\0") + attribute(_INFO_DATA, data)
        parts = [
            INFO.pack(0, TYPE_CAN, interface.index, flags, 0),
            attribute(_NAME, interface.name.encode() + b"\0"),
            attribute(_QUEUE, word(QUEUE_LENGTH)),
            attribute(_OPERATING, bytes((_OPERATES if runs else _DOWN,))),
            attribute(_LINK_MODE, bytes(1)),
            attribute(_MTU, word(interface.mtu)),
            attribute(_GROUP, word(0)),
            attribute(_PROMISCUITY, word(0)),
            attribute(_SEND_QUEUES, word(1)),
            attribute(_RECEIVE_QUEUES, word(1)),
            attribute(_CARRIER, bytes((int(runs),))),
            attribute(_QDISC, b"pfifo_fast\0"),
            *self._statistics(interface, status),
            attribute(_LINK_INFO, info + attribute(_INFO_XSTATS, controller.statistics(status))),
        ]
        return b"".join(parts)

    def seen(self, interface: Interface) -> tuple[int, bool, list[int]]:
        """The flags of an interface, whether it is running, and its COUNTS. Raises CanwireError."""
        return *_flags(interface), self._counts(interface, self._line_of(interface)[2])

    def _counts(self, interface: Interface, status: LineStatus) -> list[int]:
        """Frames; a line does not count their bytes."""
        dropped = self._setting.interfaces.dropped_by(interface.name)
        numbers = [status.frames_received, status.frames_sent, 0, 0, status.errors, 0, status.lost, dropped]
        return numbers + [0] * (len(COUNTS) - len(numbers))

    def _statistics(self, interface: Interface, status: LineStatus) -> list[bytes]:
        numbers = self._counts(interface, status)
        short = struct.pack("<23I", *(number & 0xFFFF_FFFF for number in numbers))
        return [attribute(_STATS64, struct.pack("<24Q", *numbers, 0)), attribute(_STATS, short)]

    def _line_of(self, interface: Interface) -> tuple[LinePlace, LineMode, LineStatus]:
        """The line that the interface uses or would use, its present or future mode, and its status."""
        hub, port = self._setting.hub, self._ports.known(interface.index)
        if hub.lost:
            place, status = interface.line, _AWAY
        else:
            place = port.place if port is not None else _candidate(hub, interface)
            status = place.status(hub)
        mode = status.mode if status.running else None
        return place, mode or self._wanted(interface).mode(place.info.capabilities), status

    def _wanted(self, interface: Interface) -> WantedMode:
        return interface.wanted or self._setting.wanted

    # set

    def change(self, interface: Interface, body: bytes) -> None:
        """Execute RTM_SETLINK or RTM_NEWLINK; raises Refused."""
        _, _, _, flags, mask = INFO.unpack_from(body)
        self._setting.interfaces.changed(interface)
        for kind, value in attributes_in(body[INFO.size :]).items():
            if kind == _LINK_INFO:
                self._set_up(interface, attributes_in(value).get(_INFO_DATA, b""))
            elif kind == _MTU and struct.unpack("<I", value)[0] != interface.mtu:
                raise Refused(errno.EINVAL, f"{interface.name}: its MTU is its line's")
            elif kind == _NAME and value.split(b"\0", 1)[0].decode("latin-1") != interface.name:
                raise Refused(errno.EOPNOTSUPP, "canwire run --interface NAME=LINE gives other names")
        if mask & _FLAG_UP:
            try:
                self._start(interface) if flags & _FLAG_UP else self._stop(interface)
            except InUse as error:
                raise Refused(errno.EBUSY, str(error)) from None
            except CanwireError as error:
                raise Refused(errno.ENETDOWN, str(error)) from None

    def _set_up(self, interface: Interface, data: bytes) -> None:
        place, _, status = self._line_of(interface)
        try:
            wanted = controller.asked(data, self._wanted(interface), place.info.capabilities)
        except OSError as error:
            raise Refused(error.errno or errno.EINVAL) from None
        in_use = self._ports.known(interface.index) is not None and interface.flags & UP
        if in_use and wanted.mode(place.info.capabilities).timing != (status.mode and status.mode.timing):
            raise Refused(errno.EBUSY, f"{interface.name}: {_NEEDS_DOWN}")
        interface.wanted = wanted
        self._set_restarting(interface, data)

    def _set_restarting(self, interface: Interface, data: bytes) -> None:
        port = self._ports.known(interface.index)
        up = interface.flags & UP and port is not None
        restart_ms = controller.restart_ms_asked(data)
        if restart_ms is not None and restart_ms != interface.restart_ms:
            if up:
                raise Refused(errno.EBUSY, f"{interface.name}: {_NEEDS_DOWN}")
            interface.restart_ms = restart_ms
        if controller.asks_for_restart(data):
            if port is None or not up:
                raise Refused(errno.EINVAL, f"{interface.name} is down, or no program here uses it")
            try:
                port.restarting.ask()
            except OSError as error:
                raise Refused(error.errno or errno.EIO, f"{interface.name} is not in bus-off") from None

    def _start(self, interface: Interface) -> None:
        hub, port = self._setting.hub, self._ports.known(interface.index)
        place = port.place if port is not None else _candidate(hub, interface)
        status, wanted = place.status(hub), self._wanted(interface)
        if not status.running:
            mode = wanted.mode(place.info.capabilities)
            start_line(hub, place, replace(mode, persistent=True)).close()
            if port is not None and port.lost:  # it was down when the hub went, and is not now
                port.open_again()
            elif port is not None:
                port.company.seek(wanted)
        elif not wanted.rates_agree(status.mode):
            raise Refused(
                errno.EBUSY,
                f"{place.address} runs at {format_rates(status.mode)}, {format_setter(status)}",
            )
        self._setting.interfaces.show(interface, interface.flags | UP)
        self._setting.came_up()

    def _stop(self, interface: Interface) -> None:
        hub, port = self._setting.hub, self._ports.known(interface.index)
        place = port.place if port is not None else _candidate(hub, interface)
        status = place.status(hub)
        if status.running and (port is not None or (status.mode is not None and status.mode.persistent)):
            with hub.open_control(place.board.id, place.line) as control:
                control.stop()
        if port is not None:
            port.company.leave()
        if port is None:
            self._setting.interfaces.show(interface, interface.flags & ~UP)


def _flags(interface: Interface) -> tuple[int, bool]:
    """IFF_..., and whether it is running."""
    up = bool(interface.flags & UP)
    running = up and not interface.flags & OFF
    return _NO_ARP | _ECHO | (_FLAG_UP if up else 0) | (_FLAG_RUNNING | _LOWER_UP if running else 0), running


def _candidate(hub: Hub, interface: Interface) -> LinePlace:
    """A line that runs without a program (`ip link set up`, `canwire up`), else an unused one, else the first."""
    places = find_lines(hub, interface.target, "CAN")
    able = [place for place in places if place.info.capabilities.data is not None] or places
    statuses = [(place, place.status(hub)) for place in able]
    persistent = [place for place, status in statuses if status.mode is not None and status.mode.persistent]
    unused = [place for place, status in statuses if status.unused]
    return (persistent or unused or able)[0]
