"""How a line and a channel are set up, and the status that they report."""

from __future__ import annotations

from canwire.boards.lateness import lateness_text
from canwire.values.checks import shown
from canwire.values.controller_options import ControllerOptions
from canwire.values.frozen import dataclass
from canwire.values.named import NamedInt
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.check import NodeTiming


class FilterMode(NamedInt):
    """VCI's CAN_FILTER_ modes: what a message filter does with data frames."""

    VOID = 0
    LOCK = 1
    PASS = 2
    INCLUSIVE = 3
    EXCLUSIVE = 4


class Siblings(NamedInt):
    """Which frames sent by its own line a channel gets back (source: VCI V4 manual 5.2.2, self-reception).

    OWN_FILTERED: all frames that request self-reception, through the filter (in the lab). ALL: the same frames, but
    they bypass the filter and are marked (ICanChannel). OWN: only the channel's own frames of these, which bypass the
    filter and are marked (ICanChannel2). AS_BUS: as OWN, and frames of other channels through the filter and unmarked
    (ICanChannel2 with CAN_FILTER_SRRA). EVERY: all frames that the line sends, requested or not, through the filter and
    marked (monitors). OTHERS: as if each channel had a separate line: all frames that other channels send, through the
    filter and unmarked. OTHERS_AND_OWN: the same frames, and the channel's own, marked.
    """

    OWN_FILTERED = 0
    ALL = 1
    OWN = 2
    AS_BUS = 3
    EVERY = 4
    OTHERS = 5
    OTHERS_AND_OWN = 6


@dataclass(frozen=True, slots=True)
class FilterSetup:
    """One message filter's mode, and how many identifiers its list holds (0: no filter, all frames pass)."""

    mode: FilterMode = FilterMode.INCLUSIVE
    size: int = 2048


@dataclass(frozen=True, slots=True)
class FilterContent:
    """The content of one frame format's filter: its mode, its pattern, and the patterns whose identifiers are on the
    list.

    Code and mask are VCI's: id << 1 | remote, a mask bit of 1 compares.
    """

    mode: FilterMode = FilterMode.PASS
    pattern: tuple[int, int] = (0, 0)
    listed: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True, slots=True)
class LineMode:
    """How a line is initialised.

    With `timing` None the line finds its bit rate on the running bus (`timeout_ms` of silence at most).
    `data_timing` set allows the bit-rate switch, `long_data` more than 8 bytes; without both it is a classic line.
    `registers` are values for registers of the line's chip that nothing else here sets, by their data-sheet names.
    With `loop_back` the controller receives only its own frames. A line without users is reset; one that `keeps`
    leaves the bus and stays set up, one that is `persistent` continues until it is reset. Programs of the same `kin`,
    those of one vendor's interface, may set each other's running lines up at another rate ("": no program may).
    `standard`, `extended`, `error_frames`, the filters, `note` and a kin's acceptance registers (ACR, AMR) apply to
    channels of the same kin alone: what programs of another kin receive does not change.
    `options` are further settings of an FD controller; None: those of the board in canwire.toml.
    """

    timing: BitTiming | None
    data_timing: BitTiming | None = None
    long_data: bool = False
    iso_fd: bool = True
    standard: bool = True
    extended: bool = True
    error_frames: bool = False
    listen_only: bool = False
    low_speed: bool = False
    standard_filter: FilterSetup = FilterSetup()
    extended_filter: FilterSetup = FilterSetup()
    timeout_ms: int = 1000
    note: bytes = b""  # whatever the initialiser wants to find again in the status (VCI: its own bytes)
    registers: tuple[tuple[str, int], ...] = ()
    persistent: bool = False
    loop_back: bool = False
    keeps: bool = False
    kin: str = ""
    options: ControllerOptions | None = None

    def __post_init__(self) -> None:
        for name, timing in (("timing", self.timing), ("data_timing", self.data_timing)):
            if timing is not None and not isinstance(timing, BitTiming):
                raise TypeError(
                    f"{name} {shown(timing)}: must be BitTiming or None; "
                    "BitTiming.for_bit_rate(500_000, clock_hz=80_000_000) makes one"
                )


@dataclass(frozen=True, slots=True)
class LineStatus:
    """The present state of a line. `state` is an ErrorState; `load` 0..100 %; `time_ns` the hub's time.

    `mode` has the options that are in effect, those of canwire.toml included; None: the default ones. Losses by stage:
    `refused` frames that a client queued and the line could not send, `lost` frames and events that came when a
    channel's receive queue was full; the ideal controller itself loses none. `set_by` is the program that set it up
    last, `set_by_left`: that program has nothing open on the line any more. `behind_ns` is how far bus time is behind
    the clock now, `skipped_ns` how much of it was skipped since the hub began. `obstacle` is the reason why a real
    adapter does not take part in its bus, "" if none is known. `delay_ps` is the one-way delay of its bus, and
    `drift_ppm` the deviation of its oscillator (positive: fast). `chip_timing` is the timing in the registers of the
    line's chip if it differs from that of `mode`. `neighbours` are other nodes of its bus that are not lines: nodes of
    a lab, chips attached to it.
    """

    initialised: bool
    running: bool
    mode: LineMode | None
    state: int
    tec: int
    rec: int
    last_error: int
    load: float
    transmitting: bool
    coupling_fault: bool
    frames_sent: int
    frames_received: int
    errors: int
    arbitration_losses: int
    refused: int
    lost: int
    control_holder: str
    scheduler_holder: str
    channels: int
    exclusive: bool
    time_ns: int
    set_by: str = ""
    set_by_left: bool = False
    behind_ns: int = 0
    skipped_ns: int = 0
    delay_ps: int = 0
    drift_ppm: float = 0.0
    obstacle: str = ""
    chip_timing: BitTiming | None = None
    neighbours: tuple[NodeTiming, ...] = ()

    @property
    def unused(self) -> bool:
        """Whether the line does not run and no program has a channel or the control."""
        return not (self.running or self.channels or self.control_holder)

    @property
    def lateness(self) -> str:
        """A warning for a hub whose buses cannot keep up with the clock; "" for a hub that keeps up."""
        return lateness_text(self.behind_ns, self.skipped_ns)


@dataclass(frozen=True, slots=True)
class ChannelMode:
    """How a channel is set up. Queue sizes in frames (transmit 0: it only receives), at least these.

    `exact` uses these sizes instead of rounding up to a power of two. `ticks` stamps records with
    32 bits of the board's time-stamp counter, and counts delays in ticks, instead of nanoseconds. Without `fd`
    the channel neither receives nor sends CAN FD frames.
    `filter_size` is that of the 29-bit list; 0 makes no lists at all. `events`: EventKinds. The frames of all
    `prioritised` channels of a line wait in one queue by priority, which is in the high half of each time word.
    Frames of a prioritised or `confirms` channel may carry canwire's own requests in values/record.py.
    `kin` is the interface of its program: the formats, errors and filters of LineModes of that kin apply to it.
    """

    receive: int
    transmit: int
    exact: bool = False
    ticks: bool = False
    filter_mode: FilterMode = FilterMode.PASS
    filter_size: int = 2048
    siblings: Siblings = Siblings.OWN
    events: tuple[int, ...] = ()
    frames: bool = True
    fd: bool = True
    prioritised: bool = False
    confirms: bool = False
    kin: str = ""


@dataclass(frozen=True, slots=True)
class ChannelStatus:
    """A channel's counters: accepted = read + waiting + lost, sent = delivered + aborted + refused + pending."""

    active: bool
    accepted: int
    lost: int
    sent: int
    delivered: int
    aborted: int
    refused: int
    pending: int


@dataclass(frozen=True, slots=True)
class CyclicStatus:
    """A cyclic list: whether it runs, per object 0 empty, 1 busy, 2 done, and the occurrences that were skipped."""

    running: bool
    states: tuple[int, ...]
    skipped: int
