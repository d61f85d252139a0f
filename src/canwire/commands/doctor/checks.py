"""What is well, what is worth knowing, what must be repaired, and how: one finding for each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from canwire.commands.doctor.facts import Facts, HubFacts, Port

OK, NOTE, PROBLEM = "ok", "note", "problem"
_FEW_DESCRIPTORS = 256  # a hub takes up to three for each channel
_LITTLE_MEMORY = 64 << 20  # bytes
_COARSE_TICK_S, _LONG_PAUSE_S = 1e-4, 0.02


class Finding(NamedTuple):
    """`level` is OK, NOTE or PROBLEM; `remedy` says what to do, "" if nothing has to be done."""

    level: str
    subject: str
    text: str
    remedy: str = ""


def examined(facts: Facts) -> list[Finding]:
    """All findings, in the order in which to read them."""
    return [finding for check in CHECKS for finding in check(facts)]


def _core(facts: Facts) -> Iterator[Finding]:
    where = f"canwire {facts.version}, Python {facts.python}, {facts.system}"
    if facts.compiled:
        yield Finding(OK, "core", f"{where}, compiled")
    else:
        yield Finding(
            NOTE,
            "core",
            f"{where}, uncompiled: the same results, some ten times slower",
            "install a wheel, or a C compiler and then `pip install --force-reinstall --no-binary canwire canwire`",
        )


def _extras(facts: Facts) -> Iterator[Finding]:
    if facts.extras is None:
        yield Finding(
            NOTE, "extras", "canwire runs from a folder: what is missing is not known", "pip install -e ."
        )
        return
    there = [name for name, missing in facts.extras if not missing]
    if there:
        yield Finding(OK, "extras", f"there: {', '.join(there)}")
    for name, missing in facts.extras:
        if missing:
            yield Finding(
                NOTE,
                "extras",
                f"{name}: {', '.join(missing)} missing",
                f'pip install "canwire[{name}]", if you want it',
            )


def _ports(facts: Facts) -> Iterator[Finding]:
    if facts.ports is None:
        yield Finding(
            NOTE,
            "serial ports",
            "pyserial is missing: serial adapters cannot be found",
            'pip install "canwire[hardware]"',
        )
        return
    if not facts.ports:
        yield Finding(OK, "serial ports", "none: no serial adapter is plugged in")
    for port in facts.ports:
        name = f"{port.device} ({port.description})" if port.description else port.device
        if port.may_open:
            yield Finding(OK, "serial ports", f"{name}; `canwire share {port.device}` if it is a CAN adapter")
        else:
            yield Finding(
                PROBLEM, "serial ports", f"{name}: this user may not open it", _right_to(port, facts)
            )


def _right_to(port: Port, facts: Facts) -> str:
    if not port.group or port.group == "root":
        return f"give your user the right to {port.device} by a udev rule, or run as an administrator"
    if port.group in facts.user_groups:
        return f"your user is in group {port.group} already: log out and in, or look at the mode of {port.device}"
    return f"sudo usermod -aG {port.group} $USER, then log out and in"


def _adapters(facts: Facts) -> Iterator[Finding]:
    if facts.backends is None:
        yield Finding(
            NOTE,
            "adapters",
            "python-can is missing: its adapters cannot be shared",
            'pip install "canwire[hardware]"',
        )
    else:
        yield Finding(
            OK,
            "adapters",
            f"python-can has {len(facts.backends)} backends; `canwire share python-can:pcan/PCAN_USBBUS1`, say",
        )
    for interface in facts.interfaces:
        if interface.state == "down":
            yield Finding(
                NOTE,
                "adapters",
                f"the kernel's {interface.name} is down",
                f"sudo ip link set {interface.name} up type can bitrate 500000; then `canwire bridge`",
            )
        else:
            yield Finding(
                OK,
                "adapters",
                f"the kernel's {interface.name} is {interface.state}; `canwire bridge` joins it",
            )


def _socketcan(facts: Facts) -> Iterator[Finding]:
    if facts.shim:
        yield Finding(
            NOTE,
            "SocketCAN",
            facts.shim,
            "only `canwire run` needs it: install a C compiler, then install canwire again",
        )
    else:
        yield Finding(OK, "SocketCAN", "`canwire run` can start programs that speak it")


def _hubs(facts: Facts) -> Iterator[Finding]:
    if facts.runtime_trouble:
        yield Finding(
            PROBLEM,
            "hub",
            f"sockets have no place: {facts.runtime_trouble}",
            "set XDG_RUNTIME_DIR to a folder of yours",
        )
    for hub in facts.hubs:
        yield from _hub(hub)
    if not facts.hubs:
        yield Finding(OK, "hub", "none is running; `canwire serve` starts one")


def _hub(hub: HubFacts) -> Iterator[Finding]:
    if not hub.answers:
        text = f"{hub.address}: {hub.why or 'a socket that nobody listens at'}"
        if hub.named:
            yield Finding(
                PROBLEM,
                "hub",
                text,
                f"canwire serve --socket {hub.address}, or unset CANWIRE_HUB and leave --hub out",
            )
        else:
            yield Finding(
                NOTE, "hub", f"{text}, left by a hub that was killed", f"rm {hub.address}, or `canwire serve`"
            )
        return
    yield Finding(OK, "hub", f"{hub.address} answers, with {hub.boards} boards")
    for conflict in hub.conflicts:
        yield Finding(
            PROBLEM,
            "hub",
            conflict,
            "`canwire stop LINE` the wrong one, then `canwire up LINE --bit-rate` as the others, or as it says itself",
        )
    for line in hub.troubled:
        yield Finding(PROBLEM, "lines", *line.split("\n", 1))
    if hub.late:
        yield Finding(
            PROBLEM,
            "hub",
            hub.late,
            "fewer boards and frames, the compiled core, or `canwire serve --time fast`",
        )


def _limits(facts: Facts) -> Iterator[Finding]:
    if facts.descriptors is not None:
        soft, hard = facts.descriptors
        if soft < _FEW_DESCRIPTORS:
            yield Finding(
                PROBLEM,
                "limits",
                f"{soft} descriptors for a program: a hub takes up to three for each channel",
                f"ulimit -n {max(1024, soft) if hard >= 1024 else hard}",
            )
        else:
            yield Finding(OK, "limits", f"{soft} descriptors for a program")
    if facts.shm_free is not None:
        free = f"/dev/shm has {facts.shm_free >> 20} MB left"
        if facts.shm_free < _LITTLE_MEMORY:
            yield Finding(
                NOTE,
                "limits",
                f"{free}; canwire's own queues do not need it, other programs on this machine may",
                "rm what was left there, or mount it larger (docker run --shm-size=256m)",
            )
        else:
            yield Finding(OK, "limits", free)


def _clock(facts: Facts) -> Iterator[Finding]:
    told = f"steps of {facts.tick_s * 1e9:.0f} ns; a pause of 1 ms took {facts.pause_s * 1e3:.1f} ms at most"
    if facts.tick_s > _COARSE_TICK_S or facts.pause_s > _LONG_PAUSE_S:
        yield Finding(
            NOTE,
            "clock",
            f"{told}: buses in real time keep their order, but frames come late",
            "an idler machine, or more processors for this container; `canwire serve --time fast` waits for nobody",
        )
    else:
        yield Finding(OK, "clock", told)


CHECKS: tuple[Callable[[Facts], Iterator[Finding]], ...] = (
    _core,
    _extras,
    _ports,
    _adapters,
    _socketcan,
    _hubs,
    _limits,
    _clock,
)
