"""/sys/class/net for programs: the server's interfaces, and links to those of the kernel.

The files are written again whenever a program opens one of them.
Source: the kernel's Documentation/ABI/testing/sysfs-class-net and -statistics.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from canwire.socketcan.netlink.links import COUNTS, QUEUE_LENGTH, TYPE_CAN, Links

if TYPE_CHECKING:
    from canwire.socketcan.interfaces import Interface

_KERNEL = Path("/sys/class/net")


def put_whole(path: Path, text: str) -> None:
    """Write a file so that a concurrent reader gets either the old content or the new one."""
    new = path.with_name(f".{path.name}")
    new.write_text(text, encoding="utf-8", newline="\n")
    os.replace(new, path)


class NetFiles:
    """The files below `directory`."""

    def __init__(self, directory: str, links: Links) -> None:
        self._folder = Path(directory)
        self._links = links

    def refresh(self, name: str) -> None:
        """Write the files of this interface; "": the list of all. Raises CanwireError, OSError."""
        self._folder.mkdir(exist_ok=True)
        ours = {one.name: one for one in self._links.all}
        if not name:
            self._list(ours)
        for interface in [ours[name]] if name in ours else ours.values() if not name else ():
            self._write(interface)

    def _list(self, ours: dict[str, Interface]) -> None:
        there = {entry.name for entry in self._folder.iterdir()}
        kernel = {entry.name for entry in _KERNEL.iterdir()} if _KERNEL.is_dir() else set()
        for name in kernel - there - set(ours):
            (self._folder / name).symlink_to(_KERNEL / name)
        for name in there - kernel - set(ours):
            self._remove(self._folder / name)

    def _remove(self, gone: Path) -> None:
        if gone.is_symlink():
            gone.unlink()
            return
        for path in sorted(gone.rglob("*"), reverse=True):
            path.rmdir() if path.is_dir() else path.unlink()
        gone.rmdir()

    def _write(self, interface: Interface) -> None:
        folder = self._folder / interface.name
        (folder / "statistics").mkdir(parents=True, exist_ok=True)
        for name, value in self._values(interface).items():
            put_whole(folder / name, f"{value}\n")

    def _values(self, interface: Interface) -> dict[str, object]:
        flags, running, counts = self._links.seen(interface)
        found: dict[str, object] = {
            "address": "",
            "addr_len": 0,
            "carrier": int(running),
            "dev_id": "0x0",
            "flags": f"0x{flags & 0xFFFF | flags & 0x40000:x}",
            "ifindex": interface.index,
            "iflink": interface.index,
            "ifalias": "",
            "link_mode": 0,
            "mtu": interface.mtu,
            "operstate": "up" if running else "down",
            "tx_queue_len": QUEUE_LENGTH,
            "type": TYPE_CAN,
            "uevent": f"INTERFACE={interface.name}\nIFINDEX={interface.index}",
        }
        return found | {f"statistics/{name}": count for name, count in zip(COUNTS, counts, strict=False)}
