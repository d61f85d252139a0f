"""What a machine is like, as plain values: `checks.py` judges them, `gathering.py` finds them out."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Port:
    """A serial port; `group` owns its device, "" where that means nothing."""

    device: str
    description: str
    may_open: bool
    group: str


@dataclass(frozen=True)
class Interface:
    """A CAN interface of the kernel; `state` as `ip link` has it."""

    name: str
    state: str


@dataclass(frozen=True)
class HubFacts:
    """A socket where a hub should be. `answers` is False if no hub listens; the other fields then have no meaning.

    `conflicts` are buses whose lines run at different rates, `late` what keeps its buses from keeping up with the
    clock, `troubled` lines that are bus-off, shorted or lose frames, each in a sentence.
    """

    address: str
    answers: bool
    named: bool = False  # by --hub or CANWIRE_HUB
    why: str = ""
    boards: int = 0
    conflicts: tuple[str, ...] = ()
    late: str = ""
    troubled: tuple[str, ...] = ()


@dataclass(frozen=True)
class Facts:
    """Everything that `canwire doctor` looks at.

    `extras` are canwire's own extras with the distributions that are missing for each, None where canwire was not
    installed but is run from a folder. `runtime_trouble` says why sockets cannot be made, "" if they can. `shm_free` is
    in bytes, None where there is no /dev/shm. `tick_s` is the finest step of the clock, `pause_s` how long one asked
    for as 1 ms took at most. `descriptors` are soft and hard limit, None where there is none.
    """

    system: str
    python: str
    version: str
    compiled: bool
    shim: str
    extras: tuple[tuple[str, tuple[str, ...]], ...] | None
    ports: tuple[Port, ...] | None
    interfaces: tuple[Interface, ...]
    backends: tuple[str, ...] | None
    user_groups: tuple[str, ...]
    hubs: tuple[HubFacts, ...]
    runtime_trouble: str
    descriptors: tuple[int, int] | None
    shm_free: int | None
    tick_s: float
    pause_s: float
