"""A search for the bit rate by a line itself, set up to listen only: for adapters, whose bus is not simulated."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, NamedTuple

from canwire import TYPE_MASK, BitTiming, ChannelMode, EventKind, LineMode, LinePlace, NothingHeard
from canwire.commands.live.listening import RECORD

if TYPE_CHECKING:
    from canwire import Control, Hub, HubChannel

_QUEUE = 64
_ERRORS = 3  # of one rate, after which it is wrong: the first frame may have been joined in its midst


class Candidate(NamedTuple):
    """A rate to try; `told`: report the data rate, because no frame was received with the default one."""

    nominal: BitTiming
    data: BitTiming | None
    told: bool = False


class Scan:
    """Tries candidates on a line whose control is ours; it is left stopped."""

    def __init__(self, hub: Hub, place: LinePlace, control: Control) -> None:
        self._hub = hub
        self._place = place
        self._control = control

    def search(self, candidates: list[Candidate], timeout_s: float) -> Candidate:
        """The first at which a whole frame comes; raises NothingHeard, which says whether there was anything."""
        errors = 0
        channel = self._hub.open_channel(self._place.board.id, self._place.line)
        with channel:
            channel.set_up(ChannelMode(receive=_QUEUE, transmit=0, events=(int(EventKind.ERROR),)))
            channel.activate()
            for candidate in candidates:
                seen = self._tried(channel, candidate, timeout_s)
                if seen is None:
                    return candidate if candidate.told else candidate._replace(data=None)
                errors += seen
        tried = ", ".join(str(rate) for rate in dict.fromkeys(one.nominal.bit_rate for one in candidates))
        heard = f"{errors} errors, but no frame" if errors else "no frame"
        raise NothingHeard(f"{heard} at any of these bit rates: {tried}")

    def _tried(self, channel: HubChannel, candidate: Candidate, timeout_s: float) -> int | None:
        """None if a frame came, else how many errors did."""
        mode = LineMode(
            candidate.nominal,
            candidate.data,
            long_data=candidate.data is not None,
            error_frames=True,
            listen_only=True,
        )
        self._control.initialise(mode)
        self._control.start()
        errors = 0
        try:
            end_s = self._now_s() + timeout_s
            while errors < _ERRORS and (left_s := end_s - self._now_s()) > 0:
                record = channel.receive_record(left_s)
                if record is None:
                    break
                if not RECORD.unpack(record)[2] & TYPE_MASK:
                    return None
                errors += 1
            return errors
        finally:
            self._control.stop()
            while (
                channel.receive_record(0) is not None
            ):  # what belongs to this rate is nothing to the next one
                pass

    def _now_s(self) -> float:
        return self._hub.now_ns() / 1e9 if self._hub.virtual else time.monotonic()
