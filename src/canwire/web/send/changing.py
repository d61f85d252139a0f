"""Values of a frame that change each time it is sent: counters and ramps, as "byte 7 0..255, Speed 0..8000/50"."""

from __future__ import annotations

import re
from typing import NamedTuple

from canwire import BadValue

_NUMBER = r"-?\d+(?:\.\d+)?"
_CHANGE = re.compile(
    rf"(?P<name>byte\s+\d+|[A-Za-z_]\w*)\s*[:=]?\s*(?P<low>{_NUMBER})\.\.(?P<high>{_NUMBER})"
    rf"(?P<back>\.\.{_NUMBER})?(?:\s*/\s*(?P<step>\d+(?:\.\d+)?))?"
)
LONGEST = 1_000_000  # values of one ramp


class Change(NamedTuple):
    """A signal, or byte number `byte` if that is 0 or more, changes from `low` to `high` by `step`, then steps or jumps
    back."""

    name: str
    byte: int
    low: float
    high: float
    step: float
    back: bool

    @property
    def counts(self) -> bool:
        """Whether this is a byte that increases by one and restarts at 0 after 255, as in the hub's cyclic list."""
        return self.byte >= 0 and self[2:] == (0.0, 255.0, 1.0, False)

    def __str__(self) -> str:
        back = f"..{self.low:.12g}" if self.back else ""
        step = "" if self.step == 1 else f"/{self.step:.12g}"
        return f"{self.name} {self.low:.12g}..{self.high:.12g}{back}{step}"

    def value(self, number: int) -> float:
        """Return the value in the frame with this number, from 0."""
        last = int((self.high - self.low) / self.step + 1e-9)
        if self.back and last:
            at = number % (2 * last)
            return self.low + min(at, 2 * last - at) * self.step
        return self.low + number % (last + 1) * self.step


def parsed(text: str) -> tuple[Change, ...]:
    """Parse changes with commas between them: "NAME LOW..HIGH", "NAME LOW..HIGH..LOW", optionally with "/STEP".

    Raises BadValue."""
    return tuple(_parsed(part.strip()) for part in re.split(r"[,;\n]", text) if part.strip())


def _parsed(part: str) -> Change:
    found = _CHANGE.fullmatch(part)
    if found is None:
        raise BadValue(part)
    low, high, step = float(found["low"]), float(found["high"]), float(found["step"] or 1)
    back = found["back"]
    if low > high or not step > 0 or (high - low) / step > LONGEST or (back and float(back[2:]) != low):
        raise BadValue(part)
    byte = int(found["name"].split()[1]) if found["name"].split()[0] == "byte" else -1
    if byte >= 0 and (low < 0 or high > 255 or low % 1 or high % 1 or step % 1):
        raise BadValue(part)
    return Change(found["name"], byte, low, high, step, back is not None)
