"""ACAN's hardware configuration: checks, registers, the hardware filter.

Source: INduCAN104 manual, "Hardware configuration".
"""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from canwire import BadTiming, BadValue
from canwire.acan import ACANHI, HardConfig, MachineField, acan_word
from tests.cases import each
from tests.effort import examples

double_words, octets = st.integers(0, 0xFFFF_FFFF), st.integers(0, 0xFF)


@st.composite
def configs(draw: st.DrawFn) -> HardConfig:
    ts1, ts2 = draw(st.integers(2, 17)), draw(st.integers(1, 8))
    clock = draw(st.integers(2 * (ts1 + ts2), 0xFFFF))
    most = clock // (2 * (ts1 + ts2))
    least = max(1, clock // (2 * (ts1 + ts2) * 65) + 1)
    assume(least <= most)
    return HardConfig(
        draw(double_words),
        draw(double_words),
        draw(double_words),
        draw(double_words),
        clock_khz=clock,
        rate_kbps=draw(st.integers(least, most)),
        ts1=ts1,
        ts2=ts2,
        sjw=draw(octets),
        samples=draw(octets),
        output_control=draw(octets),
        interrupts=draw(octets),
    )


def programmed(config: HardConfig) -> dict[str, int]:
    return dict(config.registers())


# The manual's trace and the usual rates at 16 MHz; BTR0, BTR1 as every SJA1000 table has them (CiA: 1 us quanta etc.)
TIMINGS = [
    ({"rate_kbps": 250, "ts1": 11, "ts2": 5, "sjw": 3}, 0x81, 0x49),
    ({"rate_kbps": 1000, "ts1": 6, "ts2": 2, "sjw": 1}, 0x00, 0x14),
    ({"rate_kbps": 500, "ts1": 14, "ts2": 2, "sjw": 1}, 0x00, 0x1C),
    ({"rate_kbps": 250, "ts1": 14, "ts2": 2, "sjw": 1}, 0x01, 0x1C),
    ({"rate_kbps": 125, "ts1": 14, "ts2": 2, "sjw": 1}, 0x03, 0x1C),
    ({"rate_kbps": 20, "ts1": 14, "ts2": 2, "sjw": 2, "samples": 3}, 0x58, 0x9C),
    ({"rate_kbps": 5, "ts1": 17, "ts2": 8, "sjw": 4, "samples": 2}, 0xFF, 0xFF),
]


@pytest.mark.conforms("AC-11", "AC-12")
@each(("given_", "btr0", "btr1"), TIMINGS)
def test_bit_timing_registers(given_: dict[str, int], btr0: int, btr1: int) -> None:
    config = HardConfig(**given_)
    assert (programmed(config)["BTR0"], programmed(config)["BTR1"]) == (btr0, btr1)


@pytest.mark.conforms("AC-12")
def test_the_configuration_of_the_manuals_trace() -> None:
    """Source: manual, "CAN Spy"."""
    config = HardConfig()
    assert config.prescaler - 1 == 1
    assert config.banner() == "Clock: 16000 KHz, Rate: 250 Kbps\nTSEG1 = 11, TSEG2 = 5, SJW = 3, MSI = 1"
    timing = config.timing()
    assert (timing.bit_rate, timing.sample_point) == (250_000, 0.6875)
    assert (timing.prescaler, timing.tseg1, timing.tseg2, timing.sjw) == (2, 10, 5, 3)


@pytest.mark.conforms("AC-11")
@given(configs())
def test_registers_are_the_manuals_formulas(config: HardConfig) -> None:
    registers, quanta = programmed(config), config.ts1 + config.ts2
    assert registers["BTR0"] & 0x3F == config.clock_khz // (config.rate_kbps * 2 * quanta) - 1
    assert registers["BTR0"] >> 6 == min(max(config.sjw - 1, 0), 3)
    assert registers["BTR1"] & 0xF == config.ts1 - 2
    assert registers["BTR1"] >> 4 & 7 == config.ts2 - 1
    assert registers["BTR1"] >> 7 == (config.samples > 1)
    assert registers["OCR"] == config.output_control
    assert registers["IER"] == (config.interrupts or 0b10101101)


@pytest.mark.conforms("AC-11")
@given(configs(), st.integers(1, 100_000_000))
def test_the_line_gets_the_same_timing(config: HardConfig, oscillator_hz: int) -> None:
    assume(oscillator_hz >= 2)
    timing = config.timing(oscillator_hz)
    assert 1 + timing.tseg1 == config.ts1
    assert timing.quanta == config.ts1 + config.ts2
    assert timing.prescaler == config.prescaler
    assert timing.clock_hz == oscillator_hz // 2
    assert timing.triple_sampling == (config.samples > 1)
    assert 1 <= timing.sjw <= 4


@pytest.mark.conforms("AC-11")
@each(("sjw", "register"), [(0, 0), (1, 0), (2, 1), (3, 2), (4, 3), (5, 3), (255, 3)])
def test_sjw_is_forced_into_bounds(sjw: int, register: int) -> None:
    assert programmed(HardConfig(sjw=sjw))["BTR0"] >> 6 == register


REFUSED = [
    ({"ts1": 1}, "hi_ts1"),
    ({"ts1": 18}, "hi_ts1"),
    ({"ts2": 0}, "hi_ts2"),
    ({"ts2": 9}, "hi_ts2"),
    ({"rate_kbps": 0}, "hi_rat"),
    ({"rate_kbps": 501}, "hi_clk"),
    ({"clock_khz": 0}, "hi_clk"),
    ({"rate_kbps": 7}, "hi_clk"),
    ({"rate_kbps": 7, "clock_khz": 14_559}, None),  # 64.99 is 64
    ({"rate_kbps": 7, "clock_khz": 14_560}, "hi_clk"),  # 65
]


@pytest.mark.conforms("AC-11")
@each(("given_", "named"), REFUSED)
def test_timings_no_register_can_hold(given_: dict[str, int], named: str | None) -> None:
    """Source: manual, "Following checks are performed"."""
    if named is None:
        assert programmed(HardConfig(**given_))["BTR0"] & 0x3F == 63
        return
    with pytest.raises(BadTiming, match=named):
        HardConfig(**given_)


@pytest.mark.conforms("AC-11")
@examples(100)
@given(rate=st.integers(0, 0xFFFF), clock=st.integers(0, 0xFFFF), ts1=octets, ts2=octets)
def test_exactly_the_manuals_checks(rate: int, clock: int, ts1: int, ts2: int) -> None:
    fits = 2 <= ts1 <= 17 and 1 <= ts2 <= 8 and rate != 0 and clock >= rate * 2 * (ts1 + ts2)
    fits = fits and clock // (rate * 2 * (ts1 + ts2)) - 1 <= 63
    try:
        HardConfig(rate_kbps=rate, clock_khz=clock, ts1=ts1, ts2=ts2)
    except BadTiming:
        assert not fits
    else:
        assert fits


@each(
    ("field", "manual", "largest"),
    [
        ("machine_id", "hi_miv", 0xFFFF_FFFF),
        ("machine_mask", "hi_mim", 0xFFFF_FFFF),
        ("broadcast_id", "hi_biv", 0xFFFF_FFFF),
        ("broadcast_mask", "hi_bim", 0xFFFF_FFFF),
        ("clock_khz", "hi_clk", 0xFFFF),
        ("rate_kbps", "hi_rat", 0xFFFF),
        ("sjw", "hi_sjw", 0xFF),
        ("samples", "hi_msi", 0xFF),
        ("output_control", "hi_ocr", 0xFF),
        ("interrupts", "hi_ien", 0xFF),
    ],
)
def test_what_no_field_holds_is_refused_by_both_names(field: str, manual: str, largest: int) -> None:
    for value in (-1, largest + 1, 1.5, None):
        with pytest.raises(BadValue, match=rf"{field} \({manual}\)"):
            HardConfig(**{field: value})  # type: ignore[arg-type]


@pytest.mark.conforms("AC-13")
@each(("interrupts", "register"), [(0, 0b10101101), (0x01, 0x01), (0xFF, 0xFF)])
def test_interrupt_enable_and_output_control(interrupts: int, register: int) -> None:
    registers = programmed(HardConfig(interrupts=interrupts))
    assert registers["IER"] == register
    assert registers["OCR"] == 0x6A
    assert programmed(HardConfig(output_control=0x1A))["OCR"] == 0x1A


@pytest.mark.conforms("AC-15")
@given(configs())
def test_the_structure_and_back(config: HardConfig) -> None:
    assert HardConfig.from_hi(config.to_hi()) == config
    assert HardConfig.unpack(config.pack()) == config
    assert config.pack() == config.to_hi().pack()


@pytest.mark.conforms("AC-11")
def test_a_structure_that_cannot_be_programmed() -> None:
    hi = HardConfig().to_hi()
    hi.hi_ts1 = 1
    with pytest.raises(BadTiming, match="hi_ts1"):
        HardConfig.from_hi(hi)
    with pytest.raises(BadTiming, match="hi_ts1"):
        HardConfig.from_hi(ACANHI())
    with pytest.raises(BadValue, match="32 bytes"):
        HardConfig.unpack(bytes(31))


@pytest.mark.conforms("AC-15")
@given(configs())
def test_registers_and_back(config: HardConfig) -> None:
    again = HardConfig.from_registers(programmed(config), config.clock_khz)
    assert again.registers() == config.registers()
    assert again.machine_id == config.machine_id & 0x1FFF_E000
    assert again.broadcast_mask == config.broadcast_mask & 0x1FFF_E000
    assert again.rate_kbps >= config.rate_kbps


def test_registers_of_the_manuals_trace() -> None:
    config = HardConfig(machine_id=1 << 18, machine_mask=7 << 18, broadcast_mask=7 << 18, interrupts=0xAD)
    assert HardConfig.from_registers(programmed(config)) == config


def test_a_chip_whose_rate_is_no_whole_number_of_kbps() -> None:
    with pytest.raises(BadTiming, match="no whole number of kbit/s"):
        HardConfig.from_registers(programmed(HardConfig()) | {"BTR0": 63, "BTR1": 0x49 | 0x07}, 1000)
    odd = HardConfig.from_registers(programmed(HardConfig()) | {"BTR0": 14, "BTR1": 0x49})
    assert odd.rate_kbps == 33


# the hardware filter


@pytest.mark.conforms("AC-19")
def test_masks_are_inverted_and_the_top_sixteen_bits_counted() -> None:
    """Source: manual, drawing of the ACAN identifier: abcdefgh in ACR0, ijklmnop in ACR1; ruling 21."""
    registers = programmed(HardConfig(0x1234_5678, 0x1FFF_FFFF, 0x0000_2000, 0x0001_E000))
    assert [registers[f"ACR{number}"] for number in range(4)] == [0x91, 0xA2, 0x00, 0x01]
    assert [registers[f"AMR{number}"] for number in range(4)] == [0x00, 0x00, 0xFF, 0xF0]
    assert [programmed(HardConfig())[f"AMR{number}"] for number in range(4)] == [0xFF] * 4


# Source: SJA1000 data sheet 6.4.15.2 (F19-F27); example of the CANBUS manual (F28-F36); reference/sja1000.md 13
VECTORS = [
    ("F19", "24653CC7", "00000000", "123", "57", True),
    ("F20", "24653CC7", "00000000", "123", "58", False),
    ("F21", "24653CC7", "00000000", "123", "", True),
    ("F22", "24653CC7", "00000000", "1E6", "99", True),
    ("F23", "24653CC7", "00000000", "1E6", "R", False),
    ("F24", "91A20A55", "00000000", "12345678", "", True),
    ("F25", "91A20A55", "00000000", "12345FFF", "R", True),
    ("F26", "91A20A55", "00000000", "12346000", "", False),
    ("F27", "91A20A55", "00000000", "014ABFFF", "", True),
    ("F28", "00006000", "00001FF0", "300", "00", True),
    ("F29", "00006000", "00001FF0", "3FF", "R", True),
    ("F30", "00006000", "00001FF0", "400", "", False),
    ("F31", "00006000", "00001FF0", "000", "00", True),
    ("F32", "00006000", "00001FF0", "000", "01", False),
    ("F33", "00006000", "00001FE0", "345", "R", False),
    ("F34", "00006000", "00001FF0", "00001ABC", "", True),
    ("F35", "00006000", "00001FF0", "0C001234", "", True),
    ("F36", "00006000", "00001FF0", "0C002000", "", False),
]


@pytest.mark.conforms("AC-19")
@each(("code", "mask", "identifier", "data", "passes"), [row[1:] for row in VECTORS])
def test_the_controllers_filter(code: str, mask: str, identifier: str, data: str, passes: bool) -> None:
    registers = programmed(HardConfig())
    registers |= {f"ACR{number}": byte for number, byte in enumerate(bytes.fromhex(code))}
    registers |= {f"AMR{number}": byte for number, byte in enumerate(bytes.fromhex(mask))}
    config = HardConfig.from_registers(registers)
    remote = data == "R"
    payload = b"" if remote else bytes.fromhex(data)
    assert config.accepts(int(identifier, 16), len(identifier) == 8, remote, payload) == passes


def by_the_data_sheet(registers: dict[str, int], frame: tuple[int, bool, bool, bytes]) -> bool:
    """Dual filter mode as the data sheet draws it, register by register, bit by bit."""
    identifier, extended, remote, data = frame
    code, mask = ([registers[f"{kind}{number}"] for number in range(4)] for kind in ("ACR", "AMR"))

    def same(number: int, bits: int, byte: int) -> bool:
        return not (code[number] ^ byte) & ~mask[number] & bits

    if extended:
        high, low = identifier >> 21, identifier >> 13 & 0xFF
        return (same(0, 0xFF, high) and same(1, 0xFF, low)) or (same(2, 0xFF, high) and same(3, 0xFF, low))
    high, low = identifier >> 3, (identifier & 7) << 5 | remote << 4
    first = same(0, 0xFF, high) and same(1, 0xF0, low)
    if data and not remote:
        first = first and same(1, 0x0F, data[0] >> 4) and same(3, 0x0F, data[0])
    return first or (same(2, 0xFF, high) and same(3, 0xF0, low))


@pytest.mark.conforms("AC-19")
@examples(100)
@given(
    config=configs(),
    bits=st.integers(0, 0xFFFF_FFFF),
    near=st.sampled_from(["machine_id", "broadcast_id", None]),
    sparse=st.integers(0, 0xFFFF_FFFF),
    extended=st.booleans(),
    remote=st.booleans(),
    data=st.binary(max_size=2),
)
def test_the_filter_is_the_data_sheets(
    config: HardConfig, bits: int, near: Any, sparse: int, extended: bool, remote: bool, data: bytes
) -> None:
    word = (getattr(config, near) if near else bits) ^ (bits & sparse & sparse >> 7 & sparse >> 13)
    identifier = word & 0x1FFF_FFFF if extended else word >> 18 & 0x7FF
    expected = by_the_data_sheet(programmed(config), (identifier, extended, remote, data))
    assert config.accepts(identifier, extended, remote, data) == expected


@pytest.mark.conforms("AC-18", "AC-19")
@given(
    machine=st.integers(1, 7), other=st.integers(0, 7), rest=st.integers(0, 0xFF), data=st.binary(max_size=8)
)
def test_a_machine_hears_its_own_messages_and_broadcasts(
    machine: int, other: int, rest: int, data: bytes
) -> None:
    field = MachineField()
    config = HardConfig(field.word(machine), field.mask, field.word(0), field.mask)
    assert config.accepts(rest << 3 | other, False, False, data) == (other in (0, machine))
    assert config.accepts((rest << 3 | other) << 18, True) == (other in (0, machine))
    assert config.accepts(rest << 3 | machine, remote=True)
    assert field.destination(acan_word(rest << 3 | machine)) == machine


@pytest.mark.conforms("AC-19")
def test_rtr_and_the_first_data_byte_where_the_masks_ask_for_them() -> None:
    """Source: manual: bit l is RTR; mnop of hi_mim, hi_miv the high nibble, of hi_bim, hi_biv the low one."""
    every_bit = 0x1FFF_FFFF
    word = acan_word(0x123)
    data_only = HardConfig(word, every_bit & ~0x1FFFF | 1 << 17, every_bit, every_bit)
    assert data_only.accepts(0x123)
    assert not data_only.accepts(0x123, remote=True)
    # 0x5A: 5 from the machine's bits 16..13, A from the broadcasts'
    first_byte = HardConfig(word | 0x5 << 13, every_bit, 0x1FFC_0000 | 0xA << 13, every_bit)
    assert first_byte.accepts(0x123, data=b"\x5a\xff")
    assert not first_byte.accepts(0x123, data=b"\x5b")
    assert not first_byte.accepts(0x123, data=b"\x6a")
    assert first_byte.accepts(0x123)


def test_a_wrong_identifier_is_refused() -> None:
    with pytest.raises(BadValue, match="identifier"):
        HardConfig().accepts(0x800)
