"""The properties and capabilities of a board, which never change while it is plugged in.

The numbers of `Feature`, `controller_type` and `bus_coupling` are VCI's (reference/vci.md section 3).
"""

from __future__ import annotations

from collections.abc import Iterable

from canwire.errors import BadTiming, NoSuchBoard
from canwire.values.frozen import dataclass
from canwire.values.mistakes.names import answers_wrong_names
from canwire.values.named import NamedFlags
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.limits import TimingLimits


class Feature(NamedFlags):
    """VCI's CAN_FEATURE_ bits."""

    STANDARD_OR_EXTENDED = 0x1
    STANDARD_AND_EXTENDED = 0x2
    REMOTE_FRAMES = 0x4
    ERROR_FRAMES = 0x8
    BUS_LOAD = 0x10
    ID_FILTER = 0x20
    LISTEN_ONLY = 0x40
    SCHEDULER = 0x80
    DELAYED_TRANSMISSION = 0x200
    SINGLE_SHOT = 0x400
    HIGH_PRIORITY = 0x800
    AUTO_BAUD = 0x1000
    EXTENDED_DATA = 0x2000
    FAST_DATA = 0x4000
    ISO_FRAME = 0x8000
    NON_ISO_FRAME = 0x10000


@dataclass(frozen=True, slots=True)
class TimingRange:
    """Ranges of the bit timing registers, both ends included; `offset_max` is that of the delay compensation."""

    prescaler: tuple[int, int]
    tseg1: tuple[int, int]
    tseg2: tuple[int, int]
    sjw: tuple[int, int]
    offset_max: int = 0

    def limits(
        self, name: str = "this board", *, quanta_min: int | None = None, ipt: int = 0
    ) -> TimingLimits:
        """The range for BitTiming's searches, which call it `name`; a bit has at least `quanta_min` quanta.

        `quanta_min` None: as few as the registers can make. `ipt` is the information processing time in quanta.
        """
        (tseg1_min, tseg1_max), (tseg2_min, tseg2_max) = self.tseg1, self.tseg2
        return TimingLimits(
            name,
            prescaler_max=self.prescaler[1],
            tseg1_max=tseg1_max,
            tseg2_max=tseg2_max,
            sjw_max=self.sjw[1],
            quanta_min=1 + tseg1_min + tseg2_min if quanta_min is None else quanta_min,
            quanta_max=1 + tseg1_max + tseg2_max,
            prescaler_min=self.prescaler[0],
            tseg1_min=tseg1_min,
            tseg2_min=tseg2_min,
            ipt=ipt,
        )


@dataclass(frozen=True, slots=True)
class Ticks:
    """A timer of a board: one tick lasts divisor / clock_hz seconds; at most `maximum` ticks can be set.

    All values are zero if the board has no such timer.
    """

    clock_hz: int = 0
    divisor: int = 0
    maximum: int = 0

    @property
    def tick_ns(self) -> int:
        """Length of a tick in nanoseconds, 0 without a timer."""
        return self.divisor * 1_000_000_000 // self.clock_hz if self.clock_hz else 0


@dataclass(frozen=True, slots=True)
class Capabilities:
    """The capabilities of one CAN line."""

    controller_type: int
    bus_coupling: int
    features: int
    clock_hz: int
    nominal: TimingRange
    data: TimingRange | None
    stamps: Ticks
    cyclic: Ticks
    delay: Ticks

    def can(self, feature: int) -> bool:
        return self.features & feature == feature

    def timing(self, bit_rate: int, sample_point: float | None = None) -> BitTiming:
        """A suitable timing for classic bits and the nominal phase, at the line's clock; raises BadTiming."""
        return self._timing(self.nominal, TimingLimits.FD_NOMINAL.quanta_min, bit_rate, sample_point)

    def data_timing(self, bit_rate: int, sample_point: float | None = None) -> BitTiming:
        """A suitable timing for the data phase, at the line's clock; raises BadTiming, also for a classic line."""
        if self.data is None:
            raise BadTiming(f"{bit_rate} bit/s for data: this line knows classic CAN only")
        return self._timing(self.data, TimingLimits.FD_DATA.quanta_min, bit_rate, sample_point)

    def _timing(
        self, registers: TimingRange, quanta_min: int, bit_rate: int, sample_point: float | None
    ) -> BitTiming:
        limits = registers.limits(quanta_min=quanta_min)
        return BitTiming.for_bit_rate(bit_rate, sample_point, clock_hz=self.clock_hz, limits=limits)


NO_CAN = Capabilities(
    0, 0, 0, 0, TimingRange((0, 0), (0, 0), (0, 0), (0, 0)), None, Ticks(), Ticks(), Ticks()
)
"""Of a line that is no CAN line."""


class LinFeature(NamedFlags):
    """VCI's LIN_FEATURE_ bits (source: reference/vci.md section 4)."""

    MASTER = 0x1
    AUTO_RATE = 0x2
    ERROR_FRAMES = 0x4
    BUS_LOAD = 0x8
    SLEEP = 0x10
    WAKE_UP = 0x20


@dataclass(frozen=True, slots=True)
class LinCapabilities:
    """The capabilities of one LIN line; `stamps` is the counter that times its messages."""

    controller_type: int
    features: int
    stamps: Ticks

    def can(self, feature: int) -> bool:
        return self.features & feature == feature


@dataclass(frozen=True, slots=True)
class LineInfo:
    """One connector: `name` counts per kind of bus from 1 ("CAN-1"), `bus` is the bus that it is plugged into.

    `bus_type` is "CAN" or "LIN"; `lin` has the capabilities of a LIN line, whose `capabilities` are NO_CAN. The numbers
    of channels to receive and to send with are limits, 0: any number.
    """

    name: str
    bus: str
    bus_type: str
    capabilities: Capabilities
    lin: LinCapabilities | None = None
    receive_channels: int = 0
    send_channels: int = 0


@answers_wrong_names
@dataclass(frozen=True, slots=True)
class BoardInfo:
    """One board in the device list.

    `id` is unique while the hub runs and new after every plug; `hardware_id` ("HW" and digits) stays.
    Versions: driver is major, minor, release, build; hardware is major, minor, branch, build. `resources` are those
    that it uses of its machine: ("I/O", "280h-29Fh"), ("IRQ", "5").
    """

    id: int
    kind: str
    hardware_id: str
    device_class: str
    description: str
    manufacturer: str
    driver_version: tuple[int, int, int, int]
    hardware_version: tuple[int, int, int, int]
    firmware_version: tuple[int, int]
    lines: tuple[LineInfo, ...]
    resources: tuple[tuple[str, str], ...] = ()


def board_named(boards: Iterable[BoardInfo], name: str) -> BoardInfo:
    """The board with this hardware id, or the first of this kind; raises NoSuchBoard with the boards plugged in."""
    there = list(boards)
    for board in there:
        if name in (board.hardware_id, board.kind):
            return board
    known = ", ".join(f"{board.hardware_id} ({board.kind})" for board in there) or "none"
    raise NoSuchBoard(f"no board {name!r}; plugged in: {known}")
