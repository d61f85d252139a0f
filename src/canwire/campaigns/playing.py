"""One run: a lab, the function, a verdict, and a digest of all frames on its buses."""

from __future__ import annotations

import hashlib
import os
import re
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any, NamedTuple

from canwire.bus.can.faults.faults import Faults
from canwire.campaigns.campaign import Campaign, Figures
from canwire.campaigns.change import Change, Chosen, flip_of
from canwire.campaigns.limit import TooLong, at_most
from canwire.campaigns.parameters import Value
from canwire.errors import BadValue, NotReceived, NotTransmitted
from canwire.lab.bench import Lab
from canwire.lab.bus import BenchBus
from canwire.lab.can.bus import LabBus
from canwire.values.checks import shown
from canwire.values.text import LogLine, format_log_line

_FAULT = re.compile(r'^  File "(.*)", line (\d+) in (.*)$', re.MULTILINE)
_VERDICTS_OF_TESTS = (AssertionError, NotReceived, NotTransmitted)


@dataclass(frozen=True)
class CampaignRun:
    """The result of one run.

    `verdict` is "passed", "failed" (an assertion or an expectation), "error" (any other exception, SystemExit and
    KeyboardInterrupt included), "crashed" (its process ended) or "timeout" (it exceeded its time limit); `reason`
    says why. `digest` is a hexadecimal digest of every frame on every bus with its time: two runs with the same digest
    were the same. Not part of the table: `trace`, the traceback; `output`, the last 65,536 bytes that it printed in a
    process of this machine; `wall_s`, its duration in s of the wall clock; `place`, the exception and the line of the
    campaign's file that raised it; `smallest`, its smallest cause in words, if it was searched.
    """

    number: int
    seed: int
    parameters: dict[str, Value]
    verdict: str
    reason: str = ""
    figures: dict[str, Value] = field(default_factory=dict)
    frames: int = 0
    error_frames: int = 0
    bus_time_ns: int = 0
    digest: str = ""
    trace: str = field(default="", compare=False)
    output: str = field(default="", compare=False)
    wall_s: float = field(default=0.0, compare=False)
    place: str = field(default="", compare=False)
    smallest: str = field(default="", compare=False)
    took: dict[str, dict[int, str]] = field(default_factory=dict, compare=False, repr=False)

    @property
    def passed(self) -> bool:
        return self.verdict == "passed"


class Order(NamedTuple):
    """A run that is to be played: its number, and its changes (None: unchanged).

    `words`: whether to record in words which frames and faults took place. `until_ns`: the run is aborted when it
    waits for bus time after that.
    """

    number: int
    change: Change | None = None
    words: bool = False
    until_ns: int | None = None


class _Watched(Lab):
    """A lab that computes a digest of the frames on its buses, and records the lines of a log if requested.

    With `until_ns` no wait may begin after that time.
    """

    def __init__(self, seed: int, log: bool, order: Order) -> None:
        super().__init__(seed=seed)
        self._until_ns = order.until_ns
        change = order.change
        self.chosen = None if change is None else Chosen(change.only, order.words)
        self.selection = self.chosen
        self._flips = [] if change is None else [flip_of(text) for text in change.flips]
        self.digest = hashlib.sha256()
        self.lines: list[tuple[int, str]] | None = [] if log else None

    def _made(self, bus: BenchBus[Any, Any, Any]) -> None:
        name = bus.name.encode()

        def witness(sender: str, record: bytes, at_ns: int) -> None:
            self.digest.update(b"%b %b %d " % (name, sender.encode(), at_ns))
            self.digest.update(record)

        bus.tell(witness)
        if not isinstance(bus, LabBus):
            return
        if self.lines is not None:
            bus.remember(1 << 24)
        for _, id, extended, bit in (flip for flip in self._flips if flip.bus == bus.name):
            Faults.flip(bus.faults, bit=bit, frame_id=id, extended=extended)  # none of the script's own

    def run_until(self, time_ns: int) -> None:
        self._check_time()
        super().run_until(time_ns)

    def advance(self, deadline_ns: int, ready: Callable[[], bool]) -> bool:
        self._check_time()
        return super().advance(deadline_ns, ready)

    def _check_time(self) -> None:
        if self._until_ns is not None and self.now_ns > self._until_ns:
            raise TooLong

    def log(self) -> list[str]:
        """All frames of the CAN buses, in the order of their ends, as lines of a candump log."""
        heard = [
            LogLine(frame.timestamp_ns, name, frame)
            for name, bus in self.buses.items()
            for _, frame in bus.recent()
        ]
        heard.sort(key=lambda line: line[:2])
        return [format_log_line(line) for line in heard]


def play(
    campaign: Campaign,
    order: Order,
    seed: int,
    *,
    log: list[str] | None = None,
    limit_s: float | None = None,
) -> CampaignRun:
    """Play a run of a campaign that was started with `seed`, for `limit_s` seconds at most (None: no limit).

    Its frames are appended to `log` as lines of a candump log.
    """
    try:
        with at_most(limit_s):
            return _play(campaign, order, seed, log)
    except TooLong as error:
        return late(campaign, order, seed, limit_s, "".join(traceback.format_exception(error)))


def late(campaign: Campaign, order: Order, seed: int, limit_s: float | None, trace: str = "") -> CampaignRun:
    """The result of a run that took too long; it contains nothing that depends on how far the run came."""
    own_seed, parameters = _beginning(campaign, order, seed)
    how_long = "in its lab" if limit_s is None else f"than {limit_s:g} s"
    return CampaignRun(order.number, own_seed, parameters, "timeout", f"longer {how_long}", trace=trace)


def crashed(campaign: Campaign, order: Order, seed: int, output: str = "") -> CampaignRun:
    """The result of a run whose process ended; its `output` may show where."""
    own_seed, parameters = _beginning(campaign, order, seed)
    return CampaignRun(
        order.number,
        own_seed,
        parameters,
        "crashed",
        "its process ended by itself",
        trace=output,
        output=output,
        place=_place_of_crash(campaign, output),
    )


def _beginning(campaign: Campaign, order: Order, seed: int) -> tuple[int, dict[str, Value]]:
    """Return the run's seed and parameters."""
    own_seed = campaign.seed_of(order.number, seed)
    own = campaign.space.at(order.number, own_seed)
    return own_seed, own if order.change is None else order.change.parameters(own)


def _play(campaign: Campaign, order: Order, seed: int, log: list[str] | None) -> CampaignRun:
    began = time.perf_counter()
    own_seed, parameters = _beginning(campaign, order, seed)
    lab = _Watched(own_seed, log is not None, order)
    figures: dict[str, Value] = {}
    verdict, reason, trace, place = "passed", "", "", ""
    try:
        figures = _checked(campaign(lab, **parameters), parameters)
    except TooLong:
        raise
    except BaseException as error:  # sys.exit() and similar end only the run: the campaign continues
        verdict, reason = _judged(error)
        trace = "".join(traceback.format_exception(error))
        place = f"{type(error).__name__}{_place(campaign, error.__traceback__)}"
    if log is not None:
        log += lab.log()
    run = CampaignRun(
        order.number,
        own_seed,
        parameters,
        verdict,
        reason,
        figures,
        sum(bus.frames for bus in lab.buses.values()) + sum(bus.frames for bus in lab.lin_buses.values()),
        sum(bus.error_frames for bus in lab.buses.values()),
        lab.now_ns,
        lab.digest.hexdigest()[:32],
        trace,
        wall_s=time.perf_counter() - began,
        place=place,
        took={} if lab.chosen is None else lab.chosen.took,
    )
    lab.close()
    return run


def _place(campaign: Campaign, trace: TracebackType | None) -> str:
    """Return the innermost line of the campaign's file in the traceback."""
    path, found = campaign.path, ""
    for frame, line in traceback.walk_tb(trace):
        if frame.f_code.co_filename == path:
            found = f" in {frame.f_code.co_name}, line {line} of {os.path.basename(path)}"
    return found


def _place_of_crash(campaign: Campaign, output: str) -> str:
    """Return the line of the campaign's file in the output of faulthandler, which lists the innermost line first."""
    for path, line, name in _FAULT.findall(output):
        if path == campaign.path:
            return f"crash in {name}, line {line} of {os.path.basename(path)}"
    return ""


def _judged(error: BaseException) -> tuple[str, str]:
    """Return the verdict and the reason for an exception."""
    kind = type(error)
    try:
        words = str(error).strip() or "no reason given"
    except Exception as fault:  # its own __str__ is broken
        words = f"it cannot be shown: {type(fault).__name__}"
    if isinstance(error, _VERDICTS_OF_TESTS) or _failed_pytest(kind):
        return "failed", words.splitlines()[0]
    return "error", f"{kind.__name__}: {words}"


def _failed_pytest(kind: type[BaseException]) -> bool:
    """Whether the exception comes from `pytest.fail`. Compares names, because pytest may not be installed."""
    return kind.__name__ == "Failed" and any(base.__module__ == "_pytest.outcomes" for base in kind.__mro__)


def _checked(figures: Figures | None, parameters: dict[str, Value]) -> dict[str, Value]:
    found = dict(figures or {})
    for name, value in found.items():
        if not isinstance(name, str) or name in parameters or name in TABLE:
            raise BadValue(f"figure {name!r}: the table has a column of that name already")
        if not isinstance(value, bool | int | float | str):
            raise TypeError(f"figure {name}: {shown(value)} must be a number, a string, True or False")
        found[name] = next(plain(value) for plain in _PLAIN if isinstance(value, plain))
    return found


_PLAIN = (bool, int, float, str)
"""A figure that is of a class derived from one of these (numpy, enum) may not be known where the table is written."""


TABLE = ("run", "seed", "verdict", "reason", "frames", "error_frames", "bus_time_ns", "digest")
"""The columns that every table has, beside the parameters (after `seed`) and the figures (after `reason`)."""
