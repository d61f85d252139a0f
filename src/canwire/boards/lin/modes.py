"""How a LIN line and its monitors are set up, and the status that they report."""

from __future__ import annotations

from dataclasses import dataclass

from canwire.boards.description import LinCapabilities, LinFeature
from canwire.boards.lateness import lateness_text
from canwire.errors import BadValue, Unsupported
from canwire.values.lin.event import LinEventKind, LinState
from canwire.values.lin.timing import AUTO_RATE, checked_rate

_ALL_KINDS = tuple(int(kind) for kind in LinEventKind)


@dataclass(frozen=True, slots=True)
class LinMode:
    """How a LIN line is initialised.

    `bit_rate` is 1,000..20,000 bit/s; for a slave also 0: it is found on a bus that is already active. Without
    `master` the line is a slave. `errors` enables error messages. `note` is data of the initialising program that the
    status returns (VCI: its own bytes). Programs of the same `kin` may set each other's running lines up at another
    rate ("": no program may).
    """

    master: bool
    bit_rate: int
    errors: bool = False
    note: bytes = b""
    kin: str = ""


@dataclass(frozen=True, slots=True)
class LinLineStatus:
    """The present state of a LIN line. `load` 0..100 %; `bit_rate` is 0 while the line searches for it.

    `status` holds VCI's LIN_STATUS_ bits: overrun 0x01, error limit 0x04, bus-off 0x08, stopped 0x10. `errors` counts
    by LinErrorKind since the start, `lost` messages that came when a monitor's queue was full. `behind_ns` is how far
    bus time is behind the clock now, `skipped_ns` how much of it was skipped since the hub began.
    """

    initialised: bool
    running: bool
    mode: LinMode | None
    state: LinState
    status: int
    bit_rate: int
    load: float
    transmitting: bool
    headers: int
    frames_sent: int
    frames_received: int
    errors: tuple[int, ...]
    lost: int
    monitors: int
    time_ns: int
    behind_ns: int = 0
    skipped_ns: int = 0

    @property
    def lateness(self) -> str:
        """A warning for a hub whose buses cannot keep up with the clock; "" for a hub that keeps up."""
        return lateness_text(self.behind_ns, self.skipped_ns)


@dataclass(frozen=True, slots=True)
class LinMonitorMode:
    """How a monitor is set up: the size of its queue in messages (at least; `exact`: this size), and what it receives.

    `ticks` stamps records with 32 bits of the board's counter instead of nanoseconds. `own`: it also receives the
    responses that its own line sends, marked. `events`: LinEventKinds.
    """

    receive: int
    exact: bool = False
    ticks: bool = False
    frames: bool = True
    own: bool = True
    events: tuple[int, ...] = _ALL_KINDS


@dataclass(frozen=True, slots=True)
class LinMonitorStatus:
    """A monitor's counters: accepted = read + waiting + lost; `fill_percent` is how full its queue is."""

    active: bool
    accepted: int
    lost: int
    fill_percent: int


def check_mode(mode: LinMode, capabilities: LinCapabilities, line: str) -> None:
    """Raise BadValue for an invalid mode, Unsupported with the name of a feature that this line lacks."""
    checked_rate(mode.bit_rate, auto=True)
    if mode.master and mode.bit_rate == AUTO_RATE:
        raise BadValue(f"{line}: only a slave finds the bit rate; a master needs one")
    wanted = {
        LinFeature.MASTER: mode.master,
        LinFeature.AUTO_RATE: mode.bit_rate == AUTO_RATE,
        LinFeature.ERROR_FRAMES: mode.errors,
    }
    for feature, asked in wanted.items():
        if asked and not capabilities.can(feature):
            raise Unsupported(f"{line} has no {feature.name}")
