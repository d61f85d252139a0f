"""The bit timing of one node, and one rule for the timings of the nodes of a bus."""

from __future__ import annotations

from canwire.values.controller_options import USUAL, ControllerOptions
from canwire.values.frozen import dataclass
from canwire.values.timing.bit_timing import BitTiming


@dataclass(frozen=True, slots=True)
class NodeTiming:
    """The timing of one node on a bus; `data` is None without a data phase.

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
        """The sample points as text, such as "87.5 %", or "87.5 % and 80 % after BRS" with a data phase."""
        data = "" if self.data is None else f" and {100 * self.data.sample_point:.4g} % after BRS"
        return f"{100 * self.nominal.sample_point:.4g} %{data}"


@dataclass(frozen=True, slots=True)
class TimingCheck:
    """One rule for these nodes: `figure` must not exceed `limit`, both in `unit`. str() is a sentence."""

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
        """The distance to the limit, in `unit`; negative if it is exceeded."""
        return self.limit - self.figure

    @property
    def used(self) -> float:
        """The used part of the limit; 1.0 is all of it."""
        if self.limit > 0:
            return self.figure / self.limit
        return float("inf") if self.exceeded else 0.0

    def __str__(self) -> str:
        figures = f"{self.figure:.4g} {self.unit}, at most {self.limit:.4g} {self.unit}"
        return f"{self.problem}: {figures}; {self.remedy} ({self.source})"
