"""The controller under test: made, sent from, asked for its counters, alike for all of them."""

from __future__ import annotations

from dataclasses import replace

from canwire import BitTiming, Frame
from canwire.boards.board import IDEAL, MCP2515, SJA1000
from canwire.boards.can.channel import Channel
from canwire.boards.catalogue import LINE_MAKERS, plug
from canwire.bus.can import node as seam
from canwire.bus.can.bus import CanBus
from canwire.drivers.driver import LineSettings
from canwire.timeline import Timeline
from canwire.values.controller_options import USUAL, ControllerOptions
from canwire.values.event import ErrorState
from canwire.values.record import SINGLE_SHOT
from tests.iso16845.frames import Spec

CONTROLLERS = {"fd": IDEAL, "tolerant": IDEAL, "sja1000": SJA1000, "mcp2515": MCP2515}
NOMINAL_FD = BitTiming(4, 29, 10, 4, clock_hz=80_000_000)  # 40 quanta of 50 ns: 500 kbit/s
DATA = BitTiming(4, 6, 3, 2, clock_hz=80_000_000)  # 10 of them: 2 Mbit/s
NOMINAL = BitTiming(1, 11, 4, 2, clock_hz=8_000_000)  # 16 quanta of 125 ns: 500 kbit/s


def segmented(kind: str, ps2: int, sjw: int = 1) -> BitTiming:
    """The usual nominal bit of a controller with another sample point."""
    usual = NOMINAL_FD if kind == "fd" else NOMINAL
    tseg1 = usual.quanta - 1 - ps2
    prop = max(0 if kind == "fd" else 1, tseg1 - max(ps2, sjw))
    return BitTiming(usual.prescaler, tseg1, ps2, sjw, clock_hz=usual.clock_hz, prop=prop)


def segmented_data(ps2: int, sjw: int = 1) -> BitTiming:
    """The same for the data phase."""
    return BitTiming(DATA.prescaler, DATA.quanta - 1 - ps2, ps2, sjw, clock_hz=DATA.clock_hz)


class Iut:
    """One controller, started and error active, alone on a bus that goes bit by bit."""

    def __init__(
        self,
        kind: str,
        timing: BitTiming | None = None,
        data: BitTiming | None = None,
        options: ControllerOptions = USUAL,
    ) -> None:
        self.kind = kind
        self.fd = kind == "fd"
        self.timing = timing or (NOMINAL_FD if self.fd else NOMINAL)
        self.data = data or (DATA if self.fd else self.timing)  # of the tester's frames, if not of its own
        options = replace(options, fd_tolerant=kind == "tolerant")
        self.timeline = Timeline()
        self.bus = CanBus(self.timeline)
        self.line = LINE_MAKERS[CONTROLLERS[kind]]("iut", self.timeline)
        plug(self.line, self.bus)
        self.line.driver.configure(LineSettings(self.timing, self.data if self.fd else None, options=options))
        self.line.driver.start(self.timeline.now_ns)
        self.channel = self.line.open(Channel(256, 64))
        self.timeline.run_until(100 * self.timing.bit_time_ps // 1000)

    def send(self, spec: Spec, *, single_shot: bool = False) -> None:
        """Ask it to transmit; it begins at once if the bus is idle."""
        self.line.send(self.channel, frame_of(spec), SINGLE_SHOT if single_shot else 0)

    def received(self) -> list[Frame]:
        """What it handed up since the last call."""
        return list(self.channel.receive.take_frames(256))

    @property
    def tec(self) -> int:
        return self.line.driver.counters().tec

    @property
    def rec(self) -> int:
        return self.line.driver.counters().rec

    @property
    def off(self) -> bool:
        """In bus-off, as its driver tells."""
        return self.line.driver.counters().state is ErrorState.BUS_OFF

    def recover(self) -> None:
        """Ask for recovery, if it has to be asked."""
        self.line.driver.restart(self.timeline.now_ns)

    def preset(self, tec: int = 0, rec: int = 0) -> None:
        """Counters as errors before would have left them."""
        node = self.line.controller
        confinement = node.confinement
        confinement.tec, confinement.rec = tec, rec
        node.count(seam.NO_RULE, self.timeline.now_ns)
        assert (self.tec, self.rec) == (tec, rec)
        assert node.passive == (tec > 127 or rec > 127)


def frame_of(spec: Spec) -> Frame:
    """What a program calls this frame."""
    return Frame(
        spec.id,
        b"" if spec.remote else spec.data,
        extended=spec.extended,
        remote=spec.remote,
        fd=spec.fd,
        bit_rate_switch=spec.fd and spec.brs,
        error_state_indicator=spec.fd and spec.esi,
        dlc=spec.code if spec.remote or (not spec.fd and spec.code > 8) else None,
    )
