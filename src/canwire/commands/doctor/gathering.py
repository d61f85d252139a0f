"""Collects facts about this machine. It opens nothing that a program may be using, and changes nothing."""

from __future__ import annotations

import os
import re
import sys
import time
from glob import glob
from importlib import metadata
from pathlib import Path

import canwire
from canwire import CanwireError, LineStatus, conflicts_on, default_address, every_line, lines_now
from canwire.commands.doctor.facts import Facts, HubFacts, Interface, Port
from canwire.commands.dump.words import state_in_words

_NOT_FOR_USERS = {"test", "dev", "docs", "bench", "pictures"}
_REQUIREMENT = re.compile(
    r"(?P<name>[A-Za-z0-9._-]+)(?:\[(?P<of>[^\]]*)\])?.*?extra == ['\"](?P<extra>[^'\"]+)"
)
_CAN = "280"  # ARPHRD_CAN
_PAUSES = 5


def gathered(hub: str | None) -> Facts:
    """Gather all facts; `hub` is the value of --hub, or None."""
    from canwire import core_mode

    address, trouble = _usual_address()
    return Facts(
        system=_system(),
        python=sys.version.split()[0],
        version=canwire.__version__,
        compiled=core_mode() == "compiled",
        shim=_shim(),
        extras=_extras(),
        ports=_ports(),
        interfaces=_interfaces(Path("/sys/class/net")),
        backends=_backends(),
        user_groups=_groups(),
        hubs=tuple(_hubs(hub or os.environ.get("CANWIRE_HUB"), address)),
        runtime_trouble=trouble,
        descriptors=_descriptors(),
        shm_free=_free("/dev/shm"),
        tick_s=time.get_clock_info("monotonic").resolution,
        pause_s=max(_pause_s() for _ in range(_PAUSES)),
    )


def _system() -> str:
    """Its name and version. On Windows the standard library's `platform` would ask a service that may not be there."""
    if sys.platform == "win32":
        version = sys.getwindowsversion()
        return f"Windows {version.major}.{version.minor}.{version.build}"
    found = os.uname()
    return f"{found.sysname} {found.release}"


def _usual_address() -> tuple[str, str]:
    try:
        return default_address(), ""
    except OSError as error:
        return "", str(error)


def _shim() -> str:
    from canwire.socketcan.launch import shim

    try:
        shim()
    except CanwireError as error:
        return str(error)
    return ""


def _extras() -> tuple[tuple[str, tuple[str, ...]], ...] | None:
    """By the package's own metadata, so that nothing is to be kept up here."""
    try:
        required = metadata.requires("canwire") or []
    except metadata.PackageNotFoundError:
        return None
    found: dict[str, list[str]] = {}
    for text in required:
        match = _REQUIREMENT.match(text)
        if match is None or match["extra"] in _NOT_FOR_USERS:
            continue
        missing = found.setdefault(match["extra"], [])
        if not _installed(match["name"]):
            missing.append(match["name"])
    return tuple((name, tuple(missing)) for name, missing in found.items())


def _installed(distribution: str) -> bool:
    try:
        metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return False
    return True


def _ports() -> tuple[Port, ...] | None:
    try:
        from serial.tools import list_ports  # type: ignore[import-untyped]
    except ModuleNotFoundError:
        return None
    except AttributeError:  # a Windows that lacks what it asks for, as Wine does: no port can be listed
        return ()
    return tuple(
        Port(port.device, "" if port.description == "n/a" else port.description, *_rights(port.device))
        for port in sorted(list_ports.comports())
        if port.hwid != "n/a"  # the ports of a mainboard that nobody has soldered in
    )


def _rights(device: str) -> tuple[bool, str]:
    """May this user open it, and whose group is it; a port without a file (COM3) is judged when it is opened."""
    if not os.path.exists(device):
        return True, ""
    return os.access(device, os.R_OK | os.W_OK), _group_name(os.stat(device).st_gid)


def _group_name(number: int) -> str:
    if sys.platform == "win32":
        return ""
    import grp

    try:
        return grp.getgrgid(number).gr_name
    except KeyError:
        return str(number)


def _groups() -> tuple[str, ...]:
    return () if sys.platform == "win32" else tuple(sorted({_group_name(one) for one in os.getgroups()}))


def _interfaces(folder: Path) -> tuple[Interface, ...]:
    found = []
    for path in sorted(folder.glob("*")):
        try:
            if (path / "type").read_text(encoding="utf-8").strip() == _CAN:
                found.append(Interface(path.name, (path / "operstate").read_text(encoding="utf-8").strip()))
        except OSError:  # gone meanwhile, or no interface
            continue
    return tuple(found)


def _backends() -> tuple[str, ...] | None:
    try:
        from can.interfaces import VALID_INTERFACES
    except ModuleNotFoundError:
        return None
    return tuple(sorted(VALID_INTERFACES))


def _hubs(named: str | None, usual: str) -> list[HubFacts]:
    """The one that is meant, and every socket beside the usual one."""
    beside = sorted(glob(os.path.join(os.path.dirname(usual), "canwire*.sock"))) if usual else []
    addresses = dict.fromkeys([*([named] if named else []), *beside])
    return [_hub(address, address == named) for address in addresses]


def _hub(address: str, named: bool) -> HubFacts:
    try:
        with canwire.connect(address, name="canwire doctor") as hub:
            lines = lines_now(hub, every_line(hub, "CAN"))
            return HubFacts(
                address,
                True,
                named,
                boards=len(hub.boards()),
                conflicts=tuple(map(str, conflicts_on(hub))),
                late=next((status.lateness for _, status in lines if status.lateness), ""),
                troubled=tuple(
                    f"{place.address} on {place.info.bus or 'no bus'} {trouble}"
                    for place, status in lines
                    if (trouble := _trouble(status))
                ),
            )
    except (CanwireError, OSError) as error:
        return HubFacts(address, False, named, why=str(error) if named else "")


def _trouble(status: LineStatus) -> str:
    """What is wrong with a line, and on the next line the remedy; "" if nothing is."""
    state = state_in_words(canwire.ErrorState(status.state))
    if status.coupling_fault:
        return "reports a fault of its wires\nlook at the cable; `canwire fault BUS --list` shows a simulated one"
    if state == "bus-off":
        return (
            f"is bus-off, TEC {status.tec}\n`canwire recover LINE`, after the cause of the errors is removed"
        )
    if state == "error passive":
        return (
            f"is error passive, TEC {status.tec}, REC {status.rec}\n"
            f"look for another bit rate (`canwire detect`), a missing terminator, or a bus without another node"
        )
    return ""


def _descriptors() -> tuple[int, int] | None:
    try:
        import resource
    except ImportError:  # Windows
        return None
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = sys.maxsize
    return (
        most if soft == resource.RLIM_INFINITY else soft,
        most if hard == resource.RLIM_INFINITY else hard,
    )


def _free(folder: str) -> int | None:
    if sys.platform == "win32" or not os.path.isdir(folder):
        return None
    found = os.statvfs(folder)
    return found.f_bavail * found.f_frsize


def _pause_s() -> float:
    began_s = time.perf_counter()
    time.sleep(0.001)
    return time.perf_counter() - began_s
