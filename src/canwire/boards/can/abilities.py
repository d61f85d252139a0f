"""Checks whether a line supports a mode or a search, before anything is changed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from canwire.boards.can.message_filter import MessageFilter, message_filter
from canwire.boards.can.modes import FilterMode, FilterSetup, LineMode
from canwire.boards.description import Feature, LineInfo
from canwire.errors import BadTiming, BadValue, LineError, Unsupported
from canwire.values.timing.bit_timing import BitTiming

LOW_SPEED_COUPLING = 1
LOW_SPEED_LIMIT = 125_000  # bit/s of a fault-tolerant transceiver; source: ISO 11898-3
_SLOWEST, _QUICKEST = 10, 20_000_000  # bit/s: what is beyond is no bit rate but a mistake
_LONGEST_MS = 1 << 32  # of silence while a line looks for a bit rate: 49 days
_NO_FRAMES = FilterSetup(FilterMode.LOCK, 0)


def check_mode(name: str, info: LineInfo, mode: LineMode) -> None:
    """Raise Unsupported with the name of a feature that the board lacks (X4-15), or another error for an invalid
    mode.
    """
    _check_features(
        name,
        info,
        {
            Feature.LISTEN_ONLY: mode.listen_only,
            Feature.ERROR_FRAMES: mode.error_frames,
            Feature.STANDARD_AND_EXTENDED: mode.standard and mode.extended,
            Feature.AUTO_BAUD: mode.timing is None,
            Feature.EXTENDED_DATA: mode.long_data,
            Feature.FAST_DATA: mode.data_timing is not None,
            Feature.NON_ISO_FRAME: not mode.iso_fd,
        },
    )
    if not mode.standard and not mode.extended:
        raise LineError(f"{name}: allow 11-bit frames, 29-bit frames, or both")
    if mode.timing is None and mode.data_timing is not None:
        raise Unsupported(f"{name}: only the nominal bit rate can be found, not that of the data")
    filter_of(mode)
    _check_timeout(name, mode.timeout_ms)
    _check_coupling(name, info, mode.low_speed)
    _check_rate(mode.timing, LOW_SPEED_LIMIT if mode.low_speed else _QUICKEST)
    _check_rate(mode.data_timing, _QUICKEST)


def check_search(
    name: str,
    info: LineInfo,
    candidates: Sequence[tuple[BitTiming, BitTiming | None]],
    timeout_ms: int,
    iso_fd: bool,
    low_speed: bool,
) -> None:
    """Raise an error for a search for the bit rate that the board does not support."""
    _check_features(
        name,
        info,
        {
            Feature.FAST_DATA: any(data is not None for _, data in candidates),
            Feature.NON_ISO_FRAME: not iso_fd,
        },
    )
    _check_timeout(name, timeout_ms)
    _check_coupling(name, info, low_speed)
    for nominal, data in candidates:
        _check_rate(nominal, _QUICKEST)
        _check_rate(data, _QUICKEST)


def filter_of(mode: LineMode) -> MessageFilter:
    """The message filter of a line that was initialised with this mode; raises BadFilter."""
    standard = _effective(mode.standard_filter) if mode.standard else _NO_FRAMES
    extended = _effective(mode.extended_filter) if mode.extended else _NO_FRAMES
    return message_filter(standard.mode, standard.size, extended.mode, extended.size)


def _effective(setup: FilterSetup) -> FilterSetup:
    """The setup that is in effect: a filter without room for identifiers passes all frames (VCI V4 manual 7.3.7,
    dwSFIds).
    """
    return setup if setup.size else FilterSetup(FilterMode.PASS, 0)


def _check_features(name: str, info: LineInfo, wanted: Mapping[Feature, bool]) -> None:
    for feature, asked in wanted.items():
        if asked and not info.capabilities.can(feature):
            raise Unsupported(f"{name} ({info.name}) has no {feature.name}")


def _check_coupling(name: str, info: LineInfo, low_speed: bool) -> None:
    if low_speed and not info.capabilities.bus_coupling & LOW_SPEED_COUPLING:
        raise Unsupported(f"{name} ({info.name}) has no low-speed coupling")


def _check_rate(timing: BitTiming | None, limit: int) -> None:
    if timing is not None and not _SLOWEST <= timing.exact_bit_rate <= limit:
        what = "low-speed coupling goes" if limit == LOW_SPEED_LIMIT else "buses go"
        raise BadTiming(f"{timing.bit_rate} bit/s: {what} from {_SLOWEST} to {limit}")


def _check_timeout(name: str, timeout_ms: int) -> None:
    if not 0 <= timeout_ms <= _LONGEST_MS:
        raise BadValue(f"{name}: {timeout_ms} ms of silence: 0 to {_LONGEST_MS}")
