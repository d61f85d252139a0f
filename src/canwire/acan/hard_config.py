"""ACAN's hardware configuration: the manual's checks, and the SJA1000's registers that follow from it.

The controller filters in dual filter mode: filter 1 (ACR0, ACR1) is for the machine, filter 2 (ACR2, ACR3) for
broadcasts. The controller compares only bits 28..13 of an ACAN identifier. For a standard frame these are all eleven
bits of the identifier, RTR in bit 17, and the first data byte in bits 16..13: its high nibble is compared with the
machine's value, its low nibble with the broadcasts' value. The manual's shifts for ACR and AMR contradict its drawing
of the identifier; this module follows the drawing.
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
_BUS = ("BTR0", "BTR1", "OCR")  # these set what the controller does; the others what ACAN programs receive


@dataclass(frozen=True, slots=True)
class HardConfig:
    """A controller's configuration. Its values are checked, so each HardConfig can be programmed.

    Identifiers are ACAN words; a 1 in a mask means that the bit is compared. `clock_khz` is the oscillator in kHz,
    `rate_kbps` the bit rate in kbit/s. A bit has `ts1` + `ts2` quanta: ts1 (2..17) before the sample point, with SYNC,
    ts2 (1..8) after it. `sjw` is limited to 1..4 when it is programmed. `samples` above 1 means triple sampling.
    `interrupts` 0 means the default, 0xAD. Raises BadTiming or BadValue with the field's name here and in the manual.
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
        """BRP + 1. It is rounded down, as in ACAN: a bit rate that the clock cannot make becomes a little too high."""
        return self.clock_khz // (self.rate_kbps * 2 * (self.ts1 + self.ts2))

    def timing(self, oscillator_hz: int | None = None) -> BitTiming:
        """The bit timing that these values give with an oscillator in Hz; None: with `clock_khz`."""
        sjw = self._register_of_sjw() + 1
        clock_hz = (oscillator_hz or self.clock_khz * 1000) // 2
        triple = self.samples > 1
        return BitTiming(self.prescaler, self.ts1 - 1, self.ts2, sjw, clock_hz, triple_sampling=triple)

    def _register_of_sjw(self) -> int:
        return min(max(self.sjw - 1, 0), 3)

    def registers(self) -> tuple[tuple[str, int], ...]:
        """The name and value of each register that is programmed into the controller."""
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
        """The configuration of a controller with this oscillator in kHz; its `registers()` are the given ones.

        Identifiers have only the compared bits, `samples` is 1 or 3, and an IER of 0 means the default.
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
        """Whether a frame passes the controller's filter for the machine, or the one for broadcasts."""
        word = acan_word(identifier, extended) | (0 if extended or not remote else _RTR)
        compared = _COMPARED if extended else _COMPARED & ~_DATA
        by_machine = (word ^ self.machine_id) & self.machine_mask & compared
        by_all = (word ^ self.broadcast_id) & self.broadcast_mask & compared
        if not extended and not remote:
            by_machine |= self._differs(data)
        return not by_machine or not by_all

    def _differs(self, data: bytes) -> int:
        """The nibbles of a standard frame's first data byte that differ from filter 1; without data none differs."""
        if not data:
            return 0
        high = ((data[0] >> 4) << _NIBBLE_SHIFT ^ self.machine_id) & self.machine_mask
        low = ((data[0] & 0xF) << _NIBBLE_SHIFT ^ self.broadcast_id) & self.broadcast_mask
        return (high | low) & _DATA

    def banner(self) -> str:
        """The first two lines of CANSPY's trace. Source: manual, "CAN Spy"."""
        return (
            f"Clock: {self.clock_khz} KHz, Rate: {self.rate_kbps} Kbps\n"
            f"TSEG1 = {self.ts1}, TSEG2 = {self.ts2}, SJW = {self.sjw}, MSI = {self.samples}"
        )

    def to_hi(self) -> ACANHI:
        """The configuration as the manual's structure."""
        made = ACANHI()
        for name, (manual, _) in _FIELDS.items():
            setattr(made, manual, getattr(self, name))
        return made

    @classmethod
    def from_hi(cls, hi: ACANHI) -> Self:
        """The configuration in the manual's structure; raises what the constructor raises."""
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
    """A line's configuration: the one in its note if an ACAN program wrote it and the registers agree, else the
    registers' values.

    Acceptance filters and interrupts, which decide what ACAN programs receive, are always those of the note, also if a
    program of another dialect has configured the line since. Raises BadTiming as `registers_of` does.
    """
    heard: dict[str, int] = {}
    with suppress(BadValue):  # no program of ours has set it up
        config = HardConfig.unpack(note)
        if all(registers.get(name, value) == value for name, value in config.registers() if name in _BUS):
            return config
        heard = {name: value for name, value in config.registers() if name not in _BUS}
    return HardConfig.from_registers(registers_of(timing, {**settings, **registers, **heard}))


def noted_interrupts(mode: LineMode | None) -> int | None:
    """The IER that an ACAN program set; None if no ACAN program has configured the line."""
    with suppress(BadValue):
        return None if mode is None else HardConfig.unpack(mode.note).interrupts or int(DEFAULT_INTERRUPTS)
    return None


def registers_of(timing: BitTiming, known: Mapping[str, int]) -> dict[str, int]:
    """All registers that `from_registers` needs, for a line with this timing; unknown ones have their default values.

    In operating mode an SJA1000 shows neither ACR nor AMR, and an adapter on a cable shows no register at all.
    Raises BadTiming if 16 MHz cannot make that rate.
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
    """The largest number of kbit/s that leads to this prescaler."""
    rate = clock_khz // (half_quanta * prescaler)
    if not rate or clock_khz // (half_quanta * rate) != prescaler:
        raise BadTiming(
            f"{clock_khz} kHz, a prescaler of {prescaler} and {half_quanta // 2} quanta give no whole number of kbit/s"
        )
    return rate
