"""The rules that a gateway applies to one frame, without I/O: filter, identifier, data, and a limit per second."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from canwire.errors import BadValue
from canwire.values.acceptance import Acceptance
from canwire.values.checks import finite, instance, shown
from canwire.values.frame import Frame

Identifier = int | tuple[int, bool]
"""An identifier; above 7FF it has 29 bits. (identifier, True) always has 29 bits."""
_SECOND_NS = 1_000_000_000
_MOST_A_SECOND = 1e7


@dataclass(frozen=True)
class GatewayRules:
    """Rules for one direction. Without rules, all frames pass unchanged.

    `filters` are (code, mask) pairs for 11-bit frames, (code, mask, True) for 29-bit ones, an Acceptance, or a function
    of a Frame; only matching frames pass. `ids` maps identifiers to new ones. `change` is called with each frame after
    that and returns the frame to send, or None to drop it. `rate` is the number of frames that may pass in any one
    second of bus time. Raises BadFilter, BadValue, TypeError.
    """

    filters: Iterable[Sequence[int]] | Acceptance | Callable[[Frame], bool] | None = None
    ids: Mapping[Identifier, Identifier] | None = None
    change: Callable[[Frame], Frame | None] | None = None
    rate: float | None = None

    def __post_init__(self) -> None:
        if self.rate is not None:
            finite("rate", self.rate, 1, _MOST_A_SECOND)
        if self.change is not None and not callable(self.change):
            raise TypeError(f"change {shown(self.change)}: must be a function of a Frame")
        self.accepts()
        self.renamed()

    def accepts(self) -> Callable[[Frame], bool] | None:
        """The filters as a function, None if all frames pass."""
        if self.filters is None or callable(self.filters):
            return self.filters
        if isinstance(self.filters, Acceptance):
            return self.filters.accepts
        return Acceptance.from_filters(self.filters).accepts

    def renamed(self) -> dict[tuple[int, bool], tuple[int, bool]]:
        """`ids` in one form: (identifier, extended) to (identifier, extended)."""
        if self.ids is None:
            return {}
        instance("ids", self.ids, Mapping)
        return {_identifier(old): _identifier(new) for old, new in self.ids.items()}


@dataclass
class GatewayCounts:
    """The counts of frames in one direction: `heard` (received) is the sum of all others.

    `passed`: arrived on the other bus; `filtered`: stopped by a filter or by `change`; `limited`: above the rate;
    `waiting`: in the transmit queue of the other line; `given_up`: were queued and did not arrive; `unfit`: CAN FD
    for a line for classic CAN only; `lost`: that queue, or this program's receive queue, was full.
    """

    heard: int = 0
    passed: int = 0
    filtered: int = 0
    limited: int = 0
    unfit: int = 0
    lost: int = 0
    waiting: int = 0
    given_up: int = 0

    def __str__(self) -> str:
        others = ("waiting", "given_up", "filtered", "limited", "unfit", "lost")
        return ", ".join(
            [
                f"{self.passed} passed",
                *(f"{n} {name.replace('_', ' ')}" for name in others if (n := getattr(self, name))),
            ]
        )


class Passage:
    """Applies the rules of one direction, and counts frames."""

    def __init__(self, rules: GatewayRules, fd: bool = True) -> None:
        self.counts = GatewayCounts()
        self._rules = rules
        self._fd = fd
        self._accepts = rules.accepts()
        self._renamed = rules.renamed()
        self._last_ns: deque[int] = deque()

    def through(self, frame: Frame) -> Frame | None:
        """Return the frame to send for this one, or None. Counts it, but the sender counts `passed` and `lost`."""
        self.counts.heard += 1
        if self._accepts is not None and not self._accepts(frame):
            self.counts.filtered += 1
            return None
        new = self._changed(frame)
        if new is None:
            self.counts.filtered += 1
        elif new.fd and not self._fd:
            self.counts.unfit += 1
        elif self._rules.rate is not None and not self._within(frame.timestamp_ns, self._rules.rate):
            self.counts.limited += 1
        else:
            return new
        return None

    def _changed(self, frame: Frame) -> Frame | None:
        renamed = self._renamed.get((frame.id, frame.extended))
        if renamed is not None:
            frame = Frame(
                renamed[0],
                frame.data,
                extended=renamed[1],
                remote=frame.remote,
                fd=frame.fd,
                bit_rate_switch=frame.bit_rate_switch,
                dlc=frame.dlc if frame.remote or not frame.fd else None,
                timestamp_ns=frame.timestamp_ns,
            )
        if self._rules.change is None:
            return frame
        changed = self._rules.change(frame)
        if changed is not None and changed.__class__ is not Frame:
            raise TypeError(f"change returned {shown(changed)} for {frame}: must be a Frame or None")
        return changed

    def _within(self, at_ns: int, rate: float) -> bool:
        while self._last_ns and self._last_ns[0] <= at_ns - _SECOND_NS:
            self._last_ns.popleft()
        if len(self._last_ns) >= rate:
            return False
        self._last_ns.append(at_ns)
        return True


def _identifier(value: Identifier) -> tuple[int, bool]:
    number, extended = value if isinstance(value, tuple) and len(value) == 2 else (value, False)
    if not isinstance(number, int) or isinstance(number, bool) or not 0 <= number < 1 << 29:
        raise BadValue(f"identifier {shown(value)}: a number up to 1FFFFFFF, or (number, True)")
    return number, bool(extended) or number > 0x7FF
