"""One node's bit timing, and one rule that the timings of a bus's nodes keep or break."""

from __future__ import annotations

from canwire.values.controller_options import USUAL, ControllerOptions
from canwire.values.frozen import dataclass
from canwire.values.timing.bit_timing import BitTiming


@dataclass(frozen=True, slots=True)
class NodeTiming:
    """How one node takes part in a bus; `data` is None where it has no data phase.

    Its oscillator is off by `ppm` (positive: fast), and by up to `within_ppm` more either way.
    """

    name: str
    nominal: BitTiming
    data: BitTiming | None = None
    ppm: float = 0.0
    within_ppm: float = 0.0
    options: ControllerOptions = USUAL

    @property
    def sample_points(self) -> str:
        """`87.5 %`, with ` and 80 % after BRS` where there is such a phase."""
        data = "" if self.data is None else f" and {100 * self.data.sample_point:.4g} % after BRS"
        return f"{100 * self.nominal.sample_point:.4g} %{data}"


@dataclass(frozen=True, slots=True)
class TimingCheck:
    """One rule for these nodes: `figure` may be `limit` at the most, both in `unit`. str() is a sentence."""

    what: str
    nodes: tuple[str, ...]
    problem: str
    figure: float
    limit: float
    unit: str
    remedy: str
    source: str

    @property
    def exceeded(self) -> bool:
        return self.figure > self.limit

    @property
    def margin(self) -> float:
        """What is left up to the limit, in `unit`; negative where it is exceeded."""
        return self.limit - self.figure

    @property
    def used(self) -> float:
        """The part of the limit that is used up; 1.0 is all of it."""
        if self.limit > 0:
            return self.figure / self.limit
        return float("inf") if self.exceeded else 0.0

    def __str__(self) -> str:
        figures = f"{self.figure:.4g} {self.unit}, at most {self.limit:.4g} {self.unit}"
        return f"{self.problem}: {figures}; {self.remedy} ({self.source})"
