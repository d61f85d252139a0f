"""The properties of the controllers: CAN_PROPERTIES for each CAN mode, the table of bit rates, and other rates.

The manual prints no table and no figures: the rates are those of CiA, the clocks and segments those of the chips' data
sheets at 16 MHz. The SJA1000 stays in its PeliCAN mode in CAN2.0A, so it has all commands and registers in both modes.
Source: CANDRV manual, 8.13 to 8.16, 8.22, 8.23; rulings.md 18.
"""

from __future__ import annotations

from dataclasses import dataclass

from canwire import BadTiming, BadValue, BitTiming, TimingLimits
from canwire.candrv.constants import NOT_IN_TABLE, CanMode, ChipsetFlags, Command
from canwire.candrv.structures import CAN_PROPERTIES

MAJOR, MINOR = 2, 6  # the manual's V2.06
VERSION = MAJOR << 8 | MINOR
RATES = (10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000)  # bit/s
EVERY_COMMAND = tuple(Command)
_FLAGS = {
    CanMode.CAN_2_0_A: ChipsetFlags.CAN_2_0_A | ChipsetFlags.CAN_2_0_B,
    CanMode.CAN_2_0_B: ChipsetFlags.CAN_2_0_A | ChipsetFlags.CAN_2_0_B | ChipsetFlags.EXT_FRAME,
}


@dataclass(frozen=True, slots=True)
class Controller:
    """A kind of controller; `clock_hz` is the clock of its time quanta, before the prescaler."""

    name: str
    clock_hz: int
    limits: TimingLimits
    registers: int
    rates: tuple[int, ...] = RATES
    max: int = 1_000_000

    @property
    def min(self) -> int:
        """The lowest rate in bit/s: the largest prescaler and the largest number of quanta."""
        return -(-self.clock_hz // (self.limits.prescaler_max * self.limits.quanta_max))

    def command(self, number: int) -> Command:
        """The command with this number; raises BadValue if there is none."""
        found = {int(one): one for one in EVERY_COMMAND}.get(number)
        if found is None:
            raise BadValue(f"command {number}: {self.name} has {_numbers(EVERY_COMMAND)}")
        return found

    def timing(self, rate: int) -> BitTiming:
        """A bit timing for a rate in bit/s; raises BadTiming outside [min, max] or if the clock cannot make it."""
        if not isinstance(rate, int) or not self.min <= rate <= self.max:
            raise BadTiming(f"{rate!r:.20} bit/s: {self.name} has {self.min} to {self.max}")
        return BitTiming.for_bit_rate(rate, clock_hz=self.clock_hz, limits=self.limits)

    def rate_of_index(self, index: int) -> int:
        """The rate in bit/s at an index of the table; raises BadTiming for an index outside the table."""
        if not isinstance(index, int) or not 0 <= index < len(self.rates):
            raise BadTiming(f"baud rate constant {index!r:.20}: it must be 0 to {len(self.rates) - 1}")
        return self.rates[index]

    def index_of_rate(self, rate: int) -> int:
        """The index of a rate in the table; 0xFFFFFFFF (-1) if the table does not contain it."""
        return self.rates.index(rate) if rate in self.rates else NOT_IN_TABLE

    def properties(self, mode: int) -> CAN_PROPERTIES:
        """What IOCTL_CAN_READ_PROPERTIES returns in a CAN mode."""
        return CAN_PROPERTIES(
            version=VERSION,
            device_name=f"F&S CAN driver V{MAJOR}.{MINOR:02}, {self.name}",
            min=self.min,
            max=self.max,
            nCommands=len(EVERY_COMMAND),
            commands=tuple(map(int, EVERY_COMMAND)),
            nBaudrates=len(self.rates),
            baudrates=self.rates,
            chipset_flags=_FLAGS[CanMode(mode)],
            nRegisters=self.registers,
        )


def _numbers(commands: tuple[Command, ...]) -> str:
    return ", ".join(f"{int(one)} {one.name}" for one in commands)


MCP2515 = Controller(
    "MCP2515",
    clock_hz=8_000_000,
    limits=TimingLimits("MCP2515", 64, 16, 8, 4, 8, 25, tseg1_min=2, tseg2_min=2, ipt=2),
    registers=128,
)
SJA1000 = Controller(
    "SJA1000",
    clock_hz=8_000_000,
    limits=TimingLimits.SJA1000,
    registers=128,
)
CONTROLLERS = {
    "picocom1": MCP2515,
    "picocom2": MCP2515,
    "picocom4": MCP2515,
    "picomod3": MCP2515,
    "netdcu": SJA1000,
}
"""By kind of board."""


def controller_of(kind: str) -> Controller:
    """The controller on a kind of board; raises BadValue for boards that CANDRV does not drive."""
    found = CONTROLLERS.get(kind)
    if found is None:
        raise BadValue(f"{kind}: CANDRV drives {', '.join(CONTROLLERS)}")
    return found
