"""ACAN's hardware configuration: the manual's checks, and the SJA1000's registers that follow from it.

Registers are the controller's own, in dual filter mode: filter 1 (ACR0, ACR1) is the machine's, filter 2 (ACR2, ACR3)
the broadcasts'. Only bits 28..13 of an ACAN identifier are compared: of a standard one all eleven, RTR in bit 17,
and in bits 16..13 the first data byte: its high nibble with the machine's value, its low one with the broadcasts'.
The manual's shifts for ACR and AMR do not fit its own drawing of the identifier; the drawing counts.
Source: INduCAN104 manual, "Hardware configuration"; SJA1000 data sheet 6.4.15.2 (dual filter), 6.5.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, fields
from typing import Self

from canwire import BadTiming, BadValue, BitTiming, LineMode, TimingLimits
from canwire.acan.constants import DEFAULT_INTERRUPTS, DEFAULT_OUTPUT_CONTROL
from canwire.acan.identifiers import acan_word
from canwire.acan.structures import ACANHI

_FIELDS = {  # the manual's name, and the largest value its type holds
    "machine_id": ("hi_miv", 0xFFFF_FFFF),
    "machine_mask": ("hi_mim", 0xFFFF_FFFF),
    "broadcast_id": ("hi_biv", 0xFFFF_FFFF),
    "broadcast_mask": ("hi_bim", 0xFFFF_FFFF),
    "clock_khz": ("hi_clk", 0xFFFF),
    "rate_kbps": ("hi_rat", 0xFFFF),
    "ts1": ("hi_ts1", 0xFF),
    "ts2": ("hi_ts2", 0xFF),
    "sjw": ("hi_sjw", 0xFF),
    "samples": ("hi_msi", 0xFF),
    "output_control": ("hi_ocr", 0xFF),
    "interrupts": ("hi_ien", 0xFF),
}
_LARGEST_PRESCALER = 64
_USUAL_HZ = 8_000_000  # half the board's oscillator
_HIGH, _LOW = 21, 13  # ACR0 is bits 28..21 of an ACAN identifier, ACR1 bits 20..13
_RTR = 1 << 17
_NIBBLE_SHIFT = 13  # bits 16..13
_DATA = 0xF << _NIBBLE_SHIFT
_COMPARED = 0xFFFF << _LOW
_BUS = ("BTR0", "BTR1", "OCR")  # what the controller does; the others say what ACAN's programs hear


@dataclass(frozen=True, slots=True)
class HardConfig:
    """How a controller is set up. A HardConfig that exists can be programmed.

    Identifiers are ACAN words, a mask's 1 is significant. `clock_khz` is the oscillator; `rate_kbps` kbit/s. A bit has
    `ts1` + `ts2` quanta: ts1 2..17 up to the sample point, SYNC included, ts2 1..8 behind it. `sjw` is forced into
    1..4 when it is programmed. More than one of `samples` samples three times. `interrupts` 0 is the default, 0xAD.
    Raises BadTiming or BadValue, naming the field and what the manual calls it.
    Source: manual, "Following checks are performed".
    """

    machine_id: int = 0
    machine_mask: int = 0
    broadcast_id: int = 0
    broadcast_mask: int = 0
    clock_khz: int = 16_000
    rate_kbps: int = 250
    ts1: int = 11
    ts2: int = 5
    sjw: int = 3
    samples: int = 1
    output_control: int = DEFAULT_OUTPUT_CONTROL
    interrupts: int = 0

    def __post_init__(self) -> None:
        for name, (_, largest) in _FIELDS.items():
            self._check(name, 0, largest, BadValue)
        self._check("ts1", 2, 17, BadTiming)
        self._check("ts2", 1, 8, BadTiming)
        self._check("rate_kbps", 1, 0xFFFF, BadTiming)
        if not 1 <= self.prescaler <= _LARGEST_PRESCALER:
            raise BadTiming(
                f"clock_khz (hi_clk) {self.clock_khz} / (rate_kbps (hi_rat) {self.rate_kbps} * 2 * "
                f"{self.ts1 + self.ts2} quanta) is {self.prescaler}: a prescaler is 1 to {_LARGEST_PRESCALER}"
            )

    def _check(self, name: str, low: int, high: int, error: type[BadValue]) -> None:
        value = getattr(self, name)
        if not isinstance(value, int) or not low <= value <= high:
            shown = f"{name} ({_FIELDS[name][0]}) is {value!r:.40}"
            raise error(f"{shown}: a whole number from {low} to {high}")

    @property
    def prescaler(self) -> int:
        """BRP + 1. Rates that the clock cannot make are made a little too quick, as ACAN's whole division does."""
        return self.clock_khz // (self.rate_kbps * 2 * (self.ts1 + self.ts2))

    def timing(self, oscillator_hz: int | None = None) -> BitTiming:
        """The bit timing that this makes of an oscillator; left out, of `clock_khz`."""
        sjw = self._register_of_sjw() + 1
        clock_hz = (oscillator_hz or self.clock_khz * 1000) // 2
        triple = self.samples > 1
        return BitTiming(self.prescaler, self.ts1 - 1, self.ts2, sjw, clock_hz, triple_sampling=triple)

    def _register_of_sjw(self) -> int:
        return min(max(self.sjw - 1, 0), 3)

    def registers(self) -> tuple[tuple[str, int], ...]:
        """What is programmed into the controller, register by register."""
        btr0 = self._register_of_sjw() << 6 | self.prescaler - 1
        btr1 = (self.samples > 1) << 7 | self.ts2 - 1 << 4 | self.ts1 - 2
        named = {"BTR0": btr0, "BTR1": btr1, "OCR": self.output_control}
        named["IER"] = self.interrupts or int(DEFAULT_INTERRUPTS)
        named["ACR0"], named["ACR1"] = _two_bytes(self.machine_id)
        named["ACR2"], named["ACR3"] = _two_bytes(self.broadcast_id)
        named["AMR0"], named["AMR1"] = _two_bytes(~self.machine_mask)
        named["AMR2"], named["AMR3"] = _two_bytes(~self.broadcast_mask)
        return tuple(named.items())

    @classmethod
    def from_registers(cls, registers: Mapping[str, int], clock_khz: int = 16_000) -> Self:
        """What somebody programmed into a controller with this oscillator: `registers()` of it are the same.

        Identifiers have only the compared bits, `samples` is 1 or 3; an IER of 0 cannot be told from the default.
        Raises BadTiming if no whole number of kbit/s leads to that prescaler.
        """
        ts1, ts2 = (registers["BTR1"] & 0xF) + 2, (registers["BTR1"] >> 4 & 7) + 1
        prescaler = (registers["BTR0"] & 0x3F) + 1
        return cls(
            machine_id=_word(registers["ACR0"], registers["ACR1"]),
            machine_mask=_word(~registers["AMR0"], ~registers["AMR1"]),
            broadcast_id=_word(registers["ACR2"], registers["ACR3"]),
            broadcast_mask=_word(~registers["AMR2"], ~registers["AMR3"]),
            clock_khz=clock_khz,
            rate_kbps=_rate(clock_khz, prescaler, 2 * (ts1 + ts2)),
            ts1=ts1,
            ts2=ts2,
            sjw=(registers["BTR0"] >> 6) + 1,
            samples=3 if registers["BTR1"] & 0x80 else 1,
            output_control=registers["OCR"],
            interrupts=registers["IER"],
        )

    def accepts(
        self, identifier: int, extended: bool = False, remote: bool = False, data: bytes = b""
    ) -> bool:
        """Whether the controller's filter lets a frame through: by the machine's filter, or the broadcasts'."""
        word = acan_word(identifier, extended) | (0 if extended or not remote else _RTR)
        compared = _COMPARED if extended else _COMPARED & ~_DATA
        by_machine = (word ^ self.machine_id) & self.machine_mask & compared
        by_all = (word ^ self.broadcast_id) & self.broadcast_mask & compared
        if not extended and not remote:
            by_machine |= self._differs(data)
        return not by_machine or not by_all

    def _differs(self, data: bytes) -> int:
        """The nibbles of a standard frame's first data byte against filter 1; a byte that is not there passes."""
        if not data:
            return 0
        high = ((data[0] >> 4) << _NIBBLE_SHIFT ^ self.machine_id) & self.machine_mask
        low = ((data[0] & 0xF) << _NIBBLE_SHIFT ^ self.broadcast_id) & self.broadcast_mask
        return (high | low) & _DATA

    def banner(self) -> str:
        """The two lines that CANSPY begins its trace with. Source: manual, "CAN Spy"."""
        return (
            f"Clock: {self.clock_khz} KHz, Rate: {self.rate_kbps} Kbps\n"
            f"TSEG1 = {self.ts1}, TSEG2 = {self.ts2}, SJW = {self.sjw}, MSI = {self.samples}"
        )

    def to_hi(self) -> ACANHI:
        """The manual's structure."""
        made = ACANHI()
        for name, (manual, _) in _FIELDS.items():
            setattr(made, manual, getattr(self, name))
        return made

    @classmethod
    def from_hi(cls, hi: ACANHI) -> Self:
        """The checked configuration; raises as the constructor does."""
        return cls(**{field.name: getattr(hi, _FIELDS[field.name][0]) for field in fields(cls)})

    def pack(self) -> bytes:
        """32 bytes, an ACANHI in memory."""
        return self.to_hi().pack()

    @classmethod
    def unpack(cls, data: bytes) -> Self:
        """The configuration in 32 bytes; raises BadValue for any other number."""
        return cls.from_hi(ACANHI.unpack(data))


def noted_config(
    note: bytes, timing: BitTiming, settings: Mapping[str, int], registers: Mapping[str, int]
) -> HardConfig:
    """How a line is set up: as its note says, if the note is ours and the registers agree; else as they are.

    What ACAN's programs hear, acceptance filters and interrupts, is as they asked for it whoever set the line up since.
    Raises BadTiming as `registers_of` does.
    """
    heard: dict[str, int] = {}
    with suppress(BadValue):  # no program of ours has set it up
        config = HardConfig.unpack(note)
        if all(registers.get(name, value) == value for name, value in config.registers() if name in _BUS):
            return config
        heard = {name: value for name, value in config.registers() if name not in _BUS}
    return HardConfig.from_registers(registers_of(timing, {**settings, **registers, **heard}))


def noted_interrupts(mode: LineMode | None) -> int | None:
    """The IER that programs of ours asked for; None where none of them has set the line up."""
    with suppress(BadValue):
        return None if mode is None else HardConfig.unpack(mode.note).interrupts or int(DEFAULT_INTERRUPTS)
    return None


def registers_of(timing: BitTiming, known: Mapping[str, int]) -> dict[str, int]:
    """All that `from_registers` needs of a line set up with this timing: what is not known is as it usually is.

    In operating mode an SJA1000 shows neither ACR nor AMR, an adapter behind a cable shows no register at all.
    Raises BadTiming where 16 MHz cannot make that rate.
    """
    if timing.clock_hz != _USUAL_HZ:
        timing = BitTiming.for_bit_rate(
            timing.bit_rate, timing.sample_point, clock_hz=_USUAL_HZ, limits=TimingLimits.SJA1000
        )
    btr0, btr1 = timing.to_btr()
    usual = {"BTR0": btr0, "BTR1": btr1, "OCR": int(DEFAULT_OUTPUT_CONTROL), "IER": int(DEFAULT_INTERRUPTS)}
    usual |= {f"ACR{number}": 0 for number in range(4)} | {f"AMR{number}": 0xFF for number in range(4)}
    return {**usual, **known}


def _two_bytes(word: int) -> tuple[int, int]:
    return word >> _HIGH & 0xFF, word >> _LOW & 0xFF


def _word(high: int, low: int) -> int:
    return (high & 0xFF) << _HIGH | (low & 0xFF) << _LOW


def _rate(clock_khz: int, prescaler: int, half_quanta: int) -> int:
    """kbit/s, the largest number that leads to this prescaler."""
    rate = clock_khz // (half_quanta * prescaler)
    if not rate or clock_khz // (half_quanta * rate) != prescaler:
        raise BadTiming(
            f"{clock_khz} kHz by a prescaler of {prescaler} and {half_quanta // 2} quanta is no whole rate in kbit/s"
        )
    return rate
