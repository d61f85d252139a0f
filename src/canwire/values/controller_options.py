"""Options of CAN FD controllers besides bit timing and mode, and the delay of a transceiver.

Source: ISO 11898-1:2015 (transmitter delay compensation, restricted operation, protocol exception, bus integration);
Bosch M_CAN user's manual (the names of offset and filter window).
"""

from __future__ import annotations

from dataclasses import fields, replace
from math import isfinite

from canwire.errors import BadValue
from canwire.values.frozen import dataclass

LONGEST_LOOP_NS = 2_000
"""Two bits of a data phase at 1 Mbit/s; transceivers have 50 to 255 ns, isolated ones some 100 more."""
LONGEST_OFFSET_NS = 100_000
"""One bit at 10 kbit/s."""


@dataclass(frozen=True, slots=True)
class DelayCompensation:
    """Transmitter delay compensation: in the data phase a sender checks its bits later, at a second sample point.

    This point follows the start of the sent bit by the delay `measured` from FDF to res, plus `offset_ns` (None: the
    offset of the sample point of the data phase). It is never earlier than `filter_ns`; an edge that would put it
    earlier is ignored. If not `measured`, the point is at `offset_ns`, which is then required.
    Nanoseconds, each 0 to 100,000. Raises BadValue.
    """

    offset_ns: float | None = None
    filter_ns: float = 0.0
    measured: bool = True

    def __post_init__(self) -> None:
        if self.offset_ns is not None:
            _check_ns("offset_ns", self.offset_ns, LONGEST_OFFSET_NS)
        _check_ns("filter_ns", self.filter_ns, LONGEST_OFFSET_NS)
        _check_switch("measured", self.measured)
        if not self.measured and self.offset_ns is None:
            raise BadValue("offset_ns None: a second sample point that is not measured needs its offset_ns")
        if not self.measured and self.filter_ns:
            raise BadValue(f"filter_ns {self.filter_ns}: only a measured delay has a filter window")


@dataclass(frozen=True, slots=True)
class ControllerOptions:
    """Options of a controller that differ from the default.

    `loop_delay_ns`: loop delay of the transceiver, 0 to 2,000: the controller reads back its levels that much later.
    `compensation`: of this delay, in the data phase of frames that it sends; None: off.
    `edge_filter`: while it waits for an idle bus, only edges followed by two dominant time quanta count.
    `restricted`: restricted operation. It receives and acknowledges, sends no frames and no flags, and does not
    change its error counters; after an error it waits for an idle bus.
    `protocol_exception`: an FD controller ignores a frame with a recessive res bit; without, it is a form error.
    `fd_tolerant`: a classic controller leaves FD frames alone in the same way, instead of destroying them.
    Raises BadValue.
    """

    loop_delay_ns: float = 0.0
    compensation: DelayCompensation | None = None
    edge_filter: bool = False
    restricted: bool = False
    protocol_exception: bool = True
    fd_tolerant: bool = False

    def __post_init__(self) -> None:
        _check_ns("loop_delay_ns", self.loop_delay_ns, LONGEST_LOOP_NS)
        if self.compensation is not None and not isinstance(self.compensation, DelayCompensation):
            raise BadValue(f"compensation {self.compensation!r}: a DelayCompensation, or None for none")
        for name in ("edge_filter", "restricted", "protocol_exception", "fd_tolerant"):
            _check_switch(name, getattr(self, name))
        if self.fd_tolerant and not self.protocol_exception:
            raise BadValue(
                "fd_tolerant True: it is a protocol exception, which protocol_exception switches off"
            )

    def unusual(self) -> list[str]:
        """The names of the options that differ from the defaults."""
        return [one.name for one in fields(self) if getattr(self, one.name) != one.default]

    def on_board(self, board: ControllerOptions) -> ControllerOptions:
        """These options, with the transceiver and the FD tolerance of the board, which programs cannot set."""
        return replace(
            self,
            loop_delay_ns=self.loop_delay_ns or board.loop_delay_ns,
            fd_tolerant=self.fd_tolerant or (board.fd_tolerant and self.protocol_exception),
        )


def _check_ns(name: str, value: float, longest: int) -> None:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not isfinite(value) or not 0 <= value <= longest:
        raise BadValue(f"{name} {value!r}: nanoseconds from 0 to {longest:,}")


def _check_switch(name: str, value: bool) -> None:
    if not isinstance(value, bool):
        raise BadValue(f"{name} {value!r}: True or False")


USUAL = ControllerOptions()
