"""/proc/net/can and /proc/net/dev for programs: receive lists, statistics, the version.

Source: Linux 6.1's net/can/proc.c (without its statistics by the second, as with stats_timer=0), net/core/net-procfs.c.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Protocol

from canwire import CanwireError
from canwire.socketcan.constants import (
    CAN_EFF_FLAG,
    CAN_EFF_MASK,
    CAN_ERR_FLAG,
    CAN_INV_FILTER,
    CAN_RTR_FLAG,
    CAN_SFF_MASK,
)
from canwire.socketcan.netlink.files import put_whole

if TYPE_CHECKING:
    from canwire.socketcan.netlink.links import Links
    from canwire.socketcan.ports import Ports

_VERSION = "rev 20170425 abi 9"
_LISTS = ("rx_err", "rx_all", "rx_fil", "rx_inv", "rx_sff", "rx_eff")
_HEADER = "  device   can_id   can_mask      function          userdata       matches  ident"
_DEVICES = Path("/proc/net/dev")
_EXACT = CAN_EFF_FLAG | CAN_RTR_FLAG


class Wanted(NamedTuple):
    """One entry of a receive list: a filter of a socket; `interface` 0: all. `matches` are those of its socket."""

    interface: int
    can_id: int
    mask: int
    ident: str
    matches: int

    @property
    def list(self) -> str:
        """The receive list that contains it in the kernel: can_rcv_list_find."""
        mask = self.mask
        if mask & CAN_ERR_FLAG:
            return "rx_err"
        if self.can_id & CAN_INV_FILTER:
            return "rx_inv"
        if not mask:
            return "rx_all"
        exact = mask & _EXACT == _EXACT and not self.can_id & CAN_RTR_FLAG
        if exact and self.can_id & CAN_EFF_FLAG and mask & CAN_EFF_MASK == CAN_EFF_MASK:
            return "rx_eff"
        if exact and not self.can_id & CAN_EFF_FLAG and mask & CAN_EFF_MASK in (CAN_SFF_MASK, CAN_EFF_MASK):
            return "rx_sff"
        return "rx_fil"

    def line(self, device: str) -> str:
        short = f"{self.can_id & 0xFFFF_FFFF:03x}"
        where = f"{short:<8}" if len(short) <= 3 else f"{self.can_id & 0xFFFF_FFFF:08x}"
        function = "0" * 16  # %pK: hidden
        return f"   {device:<5}  {where}  {self.mask:08x}  {function}  {function}  {self.matches:8}  {self.ident}"


class Hearing(Protocol):
    """A socket with receive lists."""

    def receive_list(self) -> list[Wanted]: ...


class ProcFiles:
    """The files below `directory`: `can/`, and `dev`."""

    def __init__(self, directory: str, links: Links, ports: Ports, sockets: Iterable[Hearing]) -> None:
        self._folder = Path(directory)
        self._links = links
        self._ports = ports
        self._sockets = sockets
        self._most = 0

    def refresh(self, _: str) -> None:
        """Write all files. Raises CanwireError, OSError."""
        (self._folder / "can").mkdir(parents=True, exist_ok=True)
        entries = [entry for one in self._sockets for entry in one.receive_list()]
        self._most = max(self._most, len(entries))
        self._write("can/version", _VERSION + "\n")
        self._write("can/stats", self._statistics(entries))
        self._write("can/reset_stats", "Scheduled statistic reset #1.\n")
        for name in _LISTS:
            self._write(f"can/rcvlist_{name[3:]}", "\n".join(self._list(name, entries)) + "\n\n")
        self._write("dev", self._devices())

    def _write(self, name: str, text: str) -> None:
        put_whole(self._folder / name, text)

    def _statistics(self, entries: list[Wanted]) -> str:
        numbers = {
            "transmitted frames (TXF)": self._ports.progress(),
            "received frames (RXF)": self._ports.heard(),
            "matched frames (RXMF)": self._ports.matches,
        }
        lists = {
            "current receive list entries (CRCV)": len(entries),
            "maximum receive list entries (MRCV)": self._most,
        }
        parts = ["\n".join(f" {number:8} {what}" for what, number in one.items()) for one in (numbers, lists)]
        return "\n" + "\n\n".join(parts) + "\n\n"

    def _list(self, name: str, entries: list[Wanted]) -> Iterator[str]:
        yield f"\nreceive list '{name}':"
        devices = {0: "any", **{one.index: one.name for one in self._links.all}}
        for index, device in devices.items():
            found = [one for one in entries if one.list == name and one.interface == index]
            if found:
                yield _HEADER
                yield from (one.line(device) for one in found)
            else:
                yield f"  ({device}: no entry)"

    def _devices(self) -> str:
        lines = [_DEVICES.read_text(encoding="utf-8").rstrip("\n")] if _DEVICES.exists() else []
        for interface in self._links.all:
            try:
                counts = self._links.seen(interface)[2]
            except CanwireError:
                continue  # its board has just gone
            received, sent, in_bytes, out_bytes, errors, _, lost, dropped = counts[:8]
            lines.append(
                f"{interface.name:>6}: {in_bytes:7} {received:7} {errors:4} {lost:4}    0     0          0         0 "
                f"{out_bytes:8} {sent:7}    0 {dropped:4}    0     0       0          0"
            )
        return "\n".join(lines) + "\n"
