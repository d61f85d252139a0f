"""Everything that can be wrong with a wire, at random: faults of a hub's buses that pass by themselves."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable
from random import Random

import canwire

_PARTS = (
    "frame",
    "error flag",
    "error delimiter",
    "overload flag",
    "intermission",
    "suspend",
    "idle",
    "ack",
    "eof",
)
_AT_ONCE = 6  # faults whose time may overlap


class Wire:
    """Strikes a CAN bus with these lines on it, and a LIN bus; counts what it did."""

    def __init__(self, hub: canwire.Hub, bus: str, lin_bus: str, lines: list[str], random: Random) -> None:
        self._can, self._lin = hub.bus(bus).faults, hub.lin_bus(lin_bus).faults
        self._lines = lines
        self._random = random
        self._set: deque[canwire.HubFault] = deque()
        self.struck: Counter[str] = Counter()
        self._kinds: list[Callable[[float], canwire.HubFault]] = [
            self.flip, self.inject, self.noise, self.hold, self.stuck, self.deaf, self.play, self.glitch,
            self.move_edge, self.short, self.disconnect, self.drift, self.wrong_rate, self.cable, self.babble,
            self.lin_frames, self.lin_short,
        ]  # fmt: skip

    def strike(self) -> None:
        """One more fault, for some hundredths of a second."""
        kind = self._random.choice(self._kinds)
        try:
            self._set.append(kind(self._random.uniform(0.01, 0.25)))
        except canwire.NotInitialised:  # nobody has set up the line whose rate should be another one
            self.struck["wire: a line that is not set up"] += 1
            return
        self.struck[f"wire: {kind.__name__.replace('_', ' ')}"] += 1
        while len(self._set) > _AT_ONCE:
            self._set.popleft().cancel()

    def mend(self) -> None:
        while self._set:
            self._set.popleft().cancel()

    def _seen_by(self) -> str:
        return self._random.choice(["all", "receivers", "sender", self._line()])

    def _line(self) -> str:
        return self._random.choice(self._lines)

    def _level(self) -> str:
        return self._random.choice(["dominant", "recessive"])

    def _place(self) -> canwire.HubPlace:
        return self._can.place(self._random.choice(_PARTS[:1] * 4 + _PARTS[4:]), self._random.randrange(1, 4))

    def _times(self) -> int:
        return self._random.randrange(1, 20)

    def flip(self, lasting: float) -> canwire.HubFault:
        bit, times = self._random.randrange(100), self._times()
        return self._can.flip(bit=bit, times=times, seen_by=self._seen_by(), lasting=lasting)

    def inject(self, lasting: float) -> canwire.HubFault:
        error = self._random.choice(["stuff", "form", "crc", "bit", "ack"])
        return self._can.inject(error, times=self._times(), lasting=lasting)

    def noise(self, lasting: float) -> canwire.HubFault:
        return self._can.noise(10 ** self._random.uniform(-5, -2), lasting=lasting)

    def hold(self, lasting: float) -> canwire.HubFault:
        bits = self._random.randrange(1, 30)
        return self._can.hold(
            self._level(),
            at=self._place(),
            bits=bits,
            seen_by=self._seen_by(),
            times=self._times(),
            lasting=lasting,
        )

    def stuck(self, lasting: float) -> canwire.HubFault:
        return self._can.hold("dominant", bits=None, lasting=lasting)

    def deaf(self, lasting: float) -> canwire.HubFault:
        return self._can.hold("recessive", bits=None, seen_by=self._line(), lasting=lasting)

    def play(self, lasting: float) -> canwire.HubFault:
        levels = "".join(self._random.choices("01-", k=self._random.randrange(1, 40)))
        return self._can.play(
            levels, at=self._place(), seen_by=self._seen_by(), times=self._times(), lasting=lasting
        )

    def glitch(self, lasting: float) -> canwire.HubFault:
        return self._can.glitch(
            self._level(),
            at=self._place(),
            from_ns=self._random.uniform(0, 2000),
            width_ns=self._random.uniform(10, 5000),
            times=self._times(),
            seen_by=self._seen_by(),
            lasting=lasting,
        )

    def move_edge(self, lasting: float) -> canwire.HubFault:
        place = self._can.place("frame", self._random.randrange(1, 60))
        return self._can.move_edge(
            self._random.choice([-3, -2, -1, 1, 2, 3]),
            at=place,
            to=self._level(),
            times=self._times(),
            lasting=lasting,
        )

    def short(self, lasting: float) -> canwire.HubFault:
        return self._can.short(lasting=lasting)

    def disconnect(self, lasting: float) -> canwire.HubFault:
        return self._can.disconnect(self._line(), lasting=lasting)

    def drift(self, lasting: float) -> canwire.HubFault:
        return self._can.drift(self._line(), self._random.uniform(-50_000, 50_000), lasting=lasting)

    def wrong_rate(self, lasting: float) -> canwire.HubFault:
        rate = self._random.choice([125_000, 250_000, 1_000_000])
        return self._can.wrong_rate(self._line(), rate, lasting=lasting)

    def cable(self, lasting: float) -> canwire.HubFault:
        return self._can.cable(self._random.uniform(1, 400), node_delay_ns=75, lasting=lasting)

    def babble(self, lasting: float) -> canwire.HubFault:
        return self._can.babble(
            self._random.choice([0, 0x7FF]), bytes(8), gap=self._random.choice([0, 0.002]), lasting=lasting
        )

    def lin_frames(self, lasting: float) -> canwire.HubFault:
        kinds = ["checksum", "no_response", "cut", "stop_bit", "flip", "parity", "short_break", "sync"]
        fault: canwire.HubFault = getattr(self._lin, self._random.choice(kinds))(
            times=self._times(), lasting=lasting
        )
        return fault

    def lin_short(self, lasting: float) -> canwire.HubFault:
        return self._lin.short(self._random.choice(["ground", "supply"]), lasting=lasting)
