"""The results of `log_statistics`: plain numbers."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class IdentifierStatistics:
    """All frames of one identifier on one channel, of CAN or of LIN (`lin`).

    Times are nanoseconds as in the log. Periods are seconds between consecutive frames: `mean_s`, `least_s`, `most_s`
    and `jitter_s`, their standard deviation; None with a single frame. `usual_s` is the median of the first 32 periods,
    and `gaps` counts the periods of more than three times that (none if the median is 0 because time stamps are too
    coarse); the longest period ended at `most_at_ns`. `backwards` counts time stamps earlier than that of the previous
    frame; they are in no period. `dlcs` are the length codes that occurred (LIN: bytes).
    """

    channel: str
    id: int
    extended: bool
    lin: bool
    count: int
    received: int
    transmitted: int
    remote: int
    fd: int
    dlcs: tuple[int, ...]
    first_ns: int
    last_ns: int
    mean_s: float | None
    least_s: float | None
    most_s: float | None
    jitter_s: float | None
    most_at_ns: int
    usual_s: float | None
    gaps: int
    backwards: int


@dataclass(frozen=True, slots=True)
class ChannelStatistics:
    """The statistics of one channel of a log.

    `errors` are error frames by their kind ("STUFF": 3), also those of LIN; `events` are all other events by kind.
    `lost` is the number of frames that are missing by the log's own account, `overruns` the number of frames before
    which some were lost, `gap_ns` the time that was not recorded. `bit_rate` and `data_bit_rate` in bit/s are the log's
    last ones, or those that were given; 0: unknown. `loads` are bus loads in percent for every `load_step_s` seconds
    from the log's first frame on, `load` is that of the whole log; empty and None if a bit rate is missing. If time
    stamps are coarser than a step, a step may exceed 100 %. Error frames are not in the load, because logs do not
    contain their duration.
    """

    name: str
    frames: int = 0
    lin_frames: int = 0
    received: int = 0
    transmitted: int = 0
    remote: int = 0
    fd: int = 0
    errors: dict[str, int] = field(default_factory=dict)
    errors_sending: int = 0
    events: dict[str, int] = field(default_factory=dict)
    lost: int = 0
    overruns: int = 0
    gap_ns: int = 0
    bit_rate: int = 0
    data_bit_rate: int = 0
    load: float | None = None
    load_step_s: float = 0.0
    loads: tuple[float, ...] = ()

    @property
    def peak(self) -> float | None:
        """The highest of `loads`."""
        return max(self.loads, default=None)


@dataclass(frozen=True, slots=True)
class LogStatistics:
    """The results of `log_statistics`: by channel and by identifier, in the order of names and numbers.

    `entries` is the number of readable entries, `marks` the number of marks among them; `unlisted` counts frames of
    identifiers beyond the first 65,536, and records of a damaged file that belong to no channel. Times are nanoseconds,
    counted from 1970 if `dated`.
    """

    entries: int
    marks: int
    unlisted: int
    dated: bool
    clock: str
    first_ns: int
    last_ns: int
    channels: tuple[ChannelStatistics, ...]
    identifiers: tuple[IdentifierStatistics, ...]

    @property
    def span_s(self) -> float:
        """Seconds from the first entry to the last."""
        return (self.last_ns - self.first_ns) / 1e9
