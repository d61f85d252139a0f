"""VCI's structures to a line's settings and back, on the figures of the simulated boards."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

import canwire
from canwire import FilterMode, FilterSetup, LineMode, vci
from canwire.boards.figures import USB_TO_CAN, USB_TO_CAN_FD
from canwire.vci.can import line as can_line
from canwire.vci.can import presets as bit_timing_presets
from canwire.vci.can import timing as can_timing
from canwire.vci.can.socket import capabilities2_of, capabilities_of
from tests.cases import each

BOTH = vci.CAN_OPMODE_STANDARD | vci.CAN_OPMODE_EXTENDED
FD = vci.CAN_EXMODE_EXTDATA | vci.CAN_EXMODE_FASTDATA
PRESETS = {name: value for name, value in vars(bit_timing_presets).items() if name.startswith("CAN_BTP_")}
FAST = {name: value for name, value in PRESETS.items() if "DBR" in name}
NOMINAL = {name: value for name, value in PRESETS.items() if name not in FAST and value.bps}


def without(capabilities: canwire.Capabilities, feature: int) -> canwire.Capabilities:
    return dataclasses.replace(capabilities, features=capabilities.features & ~feature)


def status(mode: LineMode | None, **changes: Any) -> canwire.LineStatus:
    """A line that is set up like this and stopped, but for these changes."""
    made = canwire.LineStatus(
        initialised=mode is not None,
        running=False,
        mode=mode,
        state=canwire.ErrorState.STOPPED,
        tec=0,
        rec=0,
        last_error=0,
        load=0.0,
        transmitting=False,
        coupling_fault=False,
        frames_sent=0,
        frames_received=0,
        errors=0,
        arbitration_losses=0,
        refused=0,
        lost=0,
        control_holder="",
        scheduler_holder="",
        channels=0,
        exclusive=False,
        time_ns=0,
    )
    return dataclasses.replace(made, **changes)


def init2(**members: Any) -> vci.CanInitLine2:
    """A line at 500 kbit/s without filters, but for these members."""
    usual = {"op_mode": BOTH, "btp_sdr": vci.CAN_BTP_500KB, "btp_fdr": vci.CAN_BTP_DBR_SL_2000KB}
    return vci.CanInitLine2(**(usual | members))


# ICanControl


@pytest.mark.conforms("X3-10", "X3-11", "X4-21")
@each("kbit", [5, 10, 20, 50, 100, 125, 250, 500, 800, 1000])
def test_registers_are_those_of_the_sja1000_at_16_mhz(kbit: int) -> None:
    init = vci.CanInitLine(
        op_mode=vci.CAN_OPMODE_STANDARD,
        bt_reg0=getattr(vci, f"CAN_BT0_{kbit}KB"),
        bt_reg1=getattr(vci, f"CAN_BT1_{kbit}KB"),
    )
    mode = can_line.mode_of_init(init, USB_TO_CAN)
    assert mode.timing is not None
    assert mode.timing.bit_rate == kbit * 1000
    assert (mode.data_timing, mode.long_data) == (None, False)
    shown = can_line.line_status(status(mode))
    assert (shown.bt_reg0, shown.bt_reg1) == (init.bt_reg0, init.bt_reg1)


@pytest.mark.conforms("X3-10")
@each(
    ("flag", "member"),
    [
        (vci.CAN_OPMODE_STANDARD, "standard"),
        (vci.CAN_OPMODE_EXTENDED, "extended"),
        (vci.CAN_OPMODE_ERRFRAME, "error_frames"),
        (vci.CAN_OPMODE_LISTONLY, "listen_only"),
        (vci.CAN_OPMODE_LOWSPEED, "low_speed"),
    ],
)
def test_mode_flags(flag: int, member: str) -> None:
    op_mode = flag | (0 if flag & BOTH else vci.CAN_OPMODE_STANDARD)
    mode = can_line.mode_of_init(vci.CanInitLine(op_mode, 0, 3, 0x1C), USB_TO_CAN)
    assert getattr(mode, member)
    assert can_line.line_status(status(mode)).op_mode == op_mode
    every = {"standard", "extended", "error_frames", "listen_only", "low_speed"}
    on = {name for name in every if getattr(mode, name)}
    assert on == {member} | ({"standard"} if op_mode & 1 else set())


def test_filters_are_inclusive_with_2048_identifiers() -> None:
    mode = can_line.mode_of_init(vci.CanInitLine(BOTH, 0, 0, 0x1C), USB_TO_CAN)
    assert mode.standard_filter == mode.extended_filter == FilterSetup(FilterMode.INCLUSIVE, 2048)


@pytest.mark.conforms("X4-23")
def test_autobaud_needs_no_timing() -> None:
    init = vci.CanInitLine(vci.CAN_OPMODE_STANDARD | vci.CAN_OPMODE_AUTOBAUD)
    assert can_line.mode_of_init(init, USB_TO_CAN).timing is None
    init = init2(op_mode=init.op_mode, btp_sdr=vci.CanBtp(mode=1))
    assert can_line.mode_of_init2(init, USB_TO_CAN).timing is None
    with pytest.raises(vci.VciNotSupported, match="cannot detect the fast data bit rate"):
        can_line.mode_of_init2(init2(op_mode=init.op_mode, ex_mode=FD), USB_TO_CAN_FD)


def test_autobauds_registers_are_those_that_were_found() -> None:
    init = vci.CanInitLine(vci.CAN_OPMODE_STANDARD | vci.CAN_OPMODE_AUTOBAUD, 0, 0x12, 0x34)
    mode = can_line.mode_of_init(init, USB_TO_CAN)
    found = dataclasses.replace(mode, timing=canwire.BitTiming.from_btr(3, 0x1C))
    shown = can_line.line_status(status(found))
    assert (shown.op_mode, shown.bt_reg0, shown.bt_reg1) == (init.op_mode, 3, 0x1C)
    shown = can_line.line_status(status(mode))
    assert (shown.bt_reg0, shown.bt_reg1) == (0, 0)


# what a board must be able to do


@pytest.mark.conforms("X4-15")
@each(
    ("op_mode", "feature"),
    [
        (BOTH, "STDANDEXT"),
        (BOTH | vci.CAN_OPMODE_ERRFRAME, "ERRFRAME"),
        (BOTH | vci.CAN_OPMODE_LISTONLY, "LISTONLY"),
        (BOTH | vci.CAN_OPMODE_AUTOBAUD, "AUTOBAUD"),
    ],
)
def test_a_missing_feature_is_named(op_mode: int, feature: str) -> None:
    poor = without(USB_TO_CAN, getattr(vci, f"CAN_FEATURE_{feature}"))
    with pytest.raises(vci.VciNotSupported, match=f"CAN_FEATURE_{feature}"):
        can_line.mode_of_init(vci.CanInitLine(op_mode, 0, 0, 0x1C), poor)
    with pytest.raises(vci.VciNotSupported, match=f"CAN_FEATURE_{feature}"):
        can_line.mode_of_init2(init2(op_mode=op_mode), poor)


@pytest.mark.conforms("X4-15")
def test_one_format_at_a_time() -> None:
    either = vci.CAN_FEATURE_STDOREXT
    poor = without(USB_TO_CAN, vci.CAN_FEATURE_STDANDEXT)
    with pytest.raises(vci.VciNotSupported, match="CAN_FEATURE_STDOREXT"):
        can_line.check_op_mode(vci.CAN_OPMODE_STANDARD, poor)
    poor = dataclasses.replace(poor, features=poor.features | either)
    can_line.check_op_mode(vci.CAN_OPMODE_STANDARD, poor)
    can_line.check_op_mode(vci.CAN_OPMODE_EXTENDED, poor)
    with pytest.raises(vci.VciNotSupported, match="CAN_FEATURE_STDANDEXT"):
        can_line.check_op_mode(BOTH, poor)


@pytest.mark.conforms("X4-43", "X4-15")
def test_low_speed_needs_that_coupling() -> None:
    can_line.check_op_mode(BOTH | vci.CAN_OPMODE_LOWSPEED, USB_TO_CAN)
    with pytest.raises(vci.VciNotSupported, match="CAN_BUSC_LOWSPEED"):
        can_line.check_op_mode(BOTH | vci.CAN_OPMODE_LOWSPEED, USB_TO_CAN_FD)


@pytest.mark.conforms("X4-15", "X4-17")
@each(
    ("ex_mode", "feature"),
    [
        (vci.CAN_EXMODE_EXTDATA, "EXTDATA"),
        (vci.CAN_EXMODE_FASTDATA, "FASTDATA"),
        (vci.CAN_EXMODE_NONISO, "NONISOFRM"),
        (vci.CAN_EXMODE_EXTDATA, "ISOFRAME"),
    ],
)
def test_a_missing_fd_feature_is_named(ex_mode: int, feature: str) -> None:
    poor = without(USB_TO_CAN_FD, getattr(vci, f"CAN_FEATURE_{feature}"))
    with pytest.raises(vci.VciNotSupported, match=f"CAN_FEATURE_{feature}"):
        can_line.mode_of_init2(init2(ex_mode=ex_mode), poor)


@pytest.mark.conforms("X4-15")
@each("ex_mode", [1, 2, 4, 7])
def test_a_classic_board_knows_no_extended_mode(ex_mode: int) -> None:
    with pytest.raises(vci.VciNotSupported):
        can_line.mode_of_init2(init2(ex_mode=ex_mode), USB_TO_CAN)


@each("op_mode", [0, vci.CAN_OPMODE_LISTONLY, BOTH | 0x40, BOTH | 0x80])
def test_impossible_operating_modes(op_mode: int) -> None:
    with pytest.raises(vci.VciInvalidArgument):
        can_line.mode_of_init(vci.CanInitLine(op_mode, 0, 0, 0x1C), USB_TO_CAN)


def test_structures_that_c_could_not_hold() -> None:
    with pytest.raises(vci.VciInvalidArgument, match="bOpMode"):
        can_line.mode_of_init(vci.CanInitLine(0x101, 0, 0, 0x1C), USB_TO_CAN)
    with pytest.raises(vci.VciInvalidArgument, match="extended operating mode"):
        can_line.mode_of_init2(init2(ex_mode=8), USB_TO_CAN_FD)


# ICanControl2


@pytest.mark.conforms("X4-17")
@each(
    ("ex_mode", "long_data", "fast", "iso"),
    [
        (vci.CAN_EXMODE_DISABLED, False, False, True),
        (vci.CAN_EXMODE_EXTDATA, True, False, True),
        (vci.CAN_EXMODE_FASTDATA, False, True, True),
        (FD, True, True, True),
        (FD | vci.CAN_EXMODE_NONISO, True, True, False),
    ],
)
def test_extended_modes_are_separate(ex_mode: int, long_data: bool, fast: bool, iso: bool) -> None:
    mode = can_line.mode_of_init2(init2(ex_mode=ex_mode), USB_TO_CAN_FD)
    assert (mode.long_data, mode.data_timing is not None, mode.iso_fd) == (long_data, fast, iso)
    assert can_line.line_status2(status(mode)).ex_mode == ex_mode


@pytest.mark.conforms("X4-18")
@pytest.mark.parametrize("capabilities", [USB_TO_CAN, USB_TO_CAN_FD], ids=["classic", "fd"])
@pytest.mark.parametrize("name", NOMINAL)
def test_presets_make_their_rate(name: str, capabilities: canwire.Capabilities) -> None:
    preset = NOMINAL[name]
    if "ABR" in name and capabilities is USB_TO_CAN:
        pytest.skip("jumps as far as tseg2 is long: for the arbitration phase of CAN FD")
    timing = can_timing.timing_of_btp(preset, capabilities, data=False)
    assert timing.bit_rate == preset.bps
    assert timing.sample_point == pytest.approx(preset.ts1 / (preset.ts1 + preset.ts2), abs=0.03)
    assert timing.tdo == 0


@pytest.mark.conforms("X4-18")
@each("name", FAST)
def test_fast_presets_make_their_rate(name: str) -> None:
    preset = FAST[name]
    timing = can_timing.timing_of_btp(preset, USB_TO_CAN_FD, data=True)
    assert abs(timing.exact_bit_rate - preset.bps) < 1
    assert timing.sample_point == pytest.approx(preset.ts1 / (preset.ts1 + preset.ts2), abs=0.04)
    clocks = timing.prescaler * timing.quanta
    assert timing.tdo == pytest.approx(preset.tdo / (preset.ts1 + preset.ts2) * clocks, abs=0.51)


@pytest.mark.conforms("X4-18")
def test_raw_values_are_the_registers() -> None:
    btp = vci.CanBtp(vci.CAN_BTMODE_RAW | vci.CAN_BTMODE_TSM, 2, 63, 16, 16)
    timing = can_timing.timing_of_btp(btp, USB_TO_CAN_FD, data=False)
    assert (timing.prescaler, timing.tseg1, timing.tseg2, timing.sjw) == (2, 63, 16, 16)
    assert (timing.clock_hz, timing.bit_rate, timing.triple_sampling) == (80_000_000, 500_000, True)
    fast = vci.CanBtp(vci.CAN_BTMODE_RAW, 2, 7, 2, 2, 16)
    assert can_timing.timing_of_btp(fast, USB_TO_CAN_FD, data=True).tdo == 16


@pytest.mark.conforms("X4-18")
@each(
    ("values", "named"),
    [
        ((1, 63, 16, 16, 0), "prescaler 1"),
        ((514, 63, 16, 16, 0), "prescaler 514"),
        ((2, 257, 16, 16, 0), "tseg1 257"),
        ((2, 63, 257, 16, 0), "tseg2 257"),
        ((2, 63, 16, 129, 0), "sjw 129"),
        ((2, 63, 16, 0, 0), "sjw 0"),
        ((2, 63, 16, 16, 256), "tdo 256"),
    ],
)
def test_raw_values_stay_in_their_ranges(values: tuple[int, ...], named: str) -> None:
    with pytest.raises(canwire.BadTiming, match=named):
        can_timing.timing_of_btp(vci.CanBtp(vci.CAN_BTMODE_RAW, *values), USB_TO_CAN_FD, data=True)


@pytest.mark.conforms("X4-18")
def test_a_rate_that_the_clock_cannot_make_is_refused_with_the_nearest() -> None:
    with pytest.raises(canwire.BadTiming, match="nearest: "):
        can_timing.timing_of_btp(vci.CanBtp(0, 499_999, 14, 2, 1), USB_TO_CAN, data=False)


@pytest.mark.conforms("X4-20")
def test_eight_and_two_allow_a_jump_of_one() -> None:
    timing = can_timing.timing_of_btp(vci.CanBtp(0, 100_000, 8, 2, 1), USB_TO_CAN, data=False)
    assert (timing.sample_point, timing.quanta, timing.sjw) == (0.8, 10, 1)
    with pytest.raises(canwire.BadTiming, match="at most 1 is allowed"):
        can_timing.timing_of_btp(vci.CanBtp(0, 100_000, 8, 2, 2), USB_TO_CAN, data=False)


@pytest.mark.conforms("X4-20")
@pytest.mark.finding("vci F12.5")
def test_only_a_can_fd_controller_may_jump_as_far_as_tseg2_is_long() -> None:
    timing = can_timing.timing_of_btp(vci.CAN_BTP_ABR_SL_500KB, USB_TO_CAN_FD, data=False)
    assert timing.sjw == timing.tseg2
    with pytest.raises(canwire.BadTiming, match="at most 1333 is allowed"):
        can_timing.timing_of_btp(vci.CAN_BTP_ABR_SL_500KB, USB_TO_CAN, data=False)


def test_the_delay_offset_may_be_placed_simply() -> None:
    ratio = vci.CanBtp(0, 2_000_000, 8, 2, 2, 0xFFFF)
    raw = vci.CanBtp(vci.CAN_BTMODE_RAW, 2, 15, 4, 4, 0xFFFF)
    for btp in (ratio, raw):
        timing = can_timing.timing_of_btp(btp, USB_TO_CAN_FD, data=True)
        assert timing.tdo == timing.prescaler * (1 + timing.tseg1) == 32


def test_unknown_timing_modes() -> None:
    with pytest.raises(vci.VciInvalidArgument, match="dwMode"):
        can_timing.timing_of_btp(vci.CanBtp(4, 500_000, 14, 2, 1), USB_TO_CAN, data=False)
    with pytest.raises(vci.VciNotSupported, match="no fast data bit rate"):
        can_timing.timing_of_btp(vci.CAN_BTP_DBR_SL_2000KB, USB_TO_CAN, data=True)


@pytest.mark.conforms("X4-34", "X4-35")
def test_filter_setups() -> None:
    init = init2(sf_mode=vci.CAN_FILTER_EXCL, sf_ids=100, ef_mode=vci.CAN_FILTER_LOCK, ef_ids=7)
    mode = can_line.mode_of_init2(init, USB_TO_CAN_FD)
    assert mode.standard_filter == FilterSetup(FilterMode.EXCLUSIVE, 100)
    assert mode.extended_filter == FilterSetup(FilterMode.LOCK, 7)
    mode = can_line.mode_of_init2(init2(sf_mode=99, ef_mode=vci.CAN_FILTER_LOCK), USB_TO_CAN_FD)
    assert mode.standard_filter == mode.extended_filter == FilterSetup(FilterMode.PASS, 0)
    for wrong in (vci.CAN_FILTER_VOID, 5, vci.CAN_FILTER_PASS | vci.CAN_FILTER_SRRA):
        with pytest.raises(vci.VciInvalidArgument, match="bEFMode"):
            can_line.mode_of_init2(init2(ef_mode=wrong, ef_ids=1), USB_TO_CAN_FD)


# status


@pytest.mark.conforms("X4-36")
def test_settings_are_read_back_as_they_were_given() -> None:
    raw = vci.CanBtp(vci.CAN_BTMODE_RAW, 2, 63, 16, 16)
    init = init2(ex_mode=FD, btp_sdr=raw, sf_mode=vci.CAN_FILTER_INCL, sf_ids=2048)
    shown = can_line.line_status2(status(can_line.mode_of_init2(init, USB_TO_CAN_FD)))
    assert (shown.op_mode, shown.ex_mode) == (BOTH, FD)
    assert (shown.btp_sdr, shown.btp_fdr) == (raw, vci.CAN_BTP_DBR_SL_2000KB)


@pytest.mark.conforms("X4-36")
def test_each_interface_reads_what_the_other_gave() -> None:
    new = can_line.mode_of_init2(init2(ex_mode=FD), USB_TO_CAN_FD)
    shown = can_line.line_status(status(new))
    assert (shown.op_mode, shown.bt_reg0, shown.bt_reg1) == (BOTH, 0x00, 0x1C)
    old = can_line.mode_of_init(vci.CanInitLine(BOTH, 0, 0x03, 0x1C), USB_TO_CAN)
    shown2 = can_line.line_status2(status(old))
    assert (shown2.op_mode, shown2.ex_mode) == (BOTH, 0)
    assert shown2.btp_sdr == vci.CanBtp(0, 125_000, 14, 2, 1)
    assert shown2.btp_fdr == vci.CanBtp()


def test_rates_beyond_the_sja1000_have_no_registers() -> None:
    raw = vci.CanBtp(vci.CAN_BTMODE_RAW, 2, 11, 4, 4)
    mode = can_line.mode_of_init2(init2(btp_sdr=raw), USB_TO_CAN_FD)
    shown = can_line.line_status(status(mode))
    assert (shown.bt_reg0, shown.bt_reg1) == (0, 0)


def test_a_line_that_others_set_up_is_described() -> None:
    nominal = canwire.BitTiming(2, 63, 16, 16, clock_hz=80_000_000)
    data = canwire.BitTiming(2, 15, 4, 4, clock_hz=80_000_000, tdo=32)
    mode = LineMode(
        nominal, data, long_data=True, iso_fd=False, extended=False, listen_only=True, note=b"mine"
    )
    shown = can_line.line_status2(status(mode))
    assert shown.op_mode == vci.CAN_OPMODE_STANDARD | vci.CAN_OPMODE_LISTONLY
    assert shown.ex_mode == FD | vci.CAN_EXMODE_NONISO
    assert shown.btp_sdr == vci.CanBtp(0, 500_000, 64, 16, 16)
    assert shown.btp_fdr == vci.CanBtp(0, 2_000_000, 16, 4, 4, 16)
    assert can_line.line_status(status(mode)).op_mode == shown.op_mode


@pytest.mark.conforms("X4-36")
@each(
    ("changes", "flags"),
    [
        ({}, vci.CAN_STATUS_ININIT),
        ({"running": True, "state": 0}, 0),
        ({"running": True, "state": 0, "transmitting": True}, vci.CAN_STATUS_TXPEND),
        ({"running": True, "state": 1}, vci.CAN_STATUS_ERRLIM),
        ({"running": True, "state": 2}, vci.CAN_STATUS_ERRLIM),
        ({"running": True, "state": 3}, vci.CAN_STATUS_ERRLIM | vci.CAN_STATUS_BUSOFF),
        ({"coupling_fault": True}, vci.CAN_STATUS_ININIT | vci.CAN_STATUS_BUSCERR),
    ],
)
def test_status_flags(changes: dict[str, Any], flags: int) -> None:
    mode = can_line.mode_of_init(vci.CanInitLine(BOTH, 0, 0, 0x1C), USB_TO_CAN)
    for shown in (can_line.line_status, can_line.line_status2):
        assert shown(status(mode, **changes)).status == flags


@pytest.mark.conforms("X4-36")
@each(("load", "shown"), [(0.0, 0), (49.6, 50), (100.0, 100), (100.4, 100)])
def test_bus_load_is_percent(load: float, shown: int) -> None:
    assert can_line.line_status(status(None, load=load)).bus_load == shown
    assert can_line.line_status2(status(None, load=load)).bus_load == shown


def test_before_anybody_set_it_up_a_line_is_undefined() -> None:
    assert can_line.line_status(status(None)) == vci.CanLineStatus(status=vci.CAN_STATUS_ININIT)
    assert can_line.line_status2(status(None)) == vci.CanLineStatus2(status=vci.CAN_STATUS_ININIT)


# capabilities


@pytest.mark.conforms("X4-14")
def test_capabilities_of_a_classic_line() -> None:
    for caps in (capabilities_of(USB_TO_CAN), capabilities2_of(USB_TO_CAN)):
        assert caps.ctrl_type == vci.CAN_CTRL_BXCAN
        assert caps.bus_coupling == vci.CAN_BUSC_HIGHSPEED | vci.CAN_BUSC_LOWSPEED
        for feature in ("STDANDEXT", "RMTFRAME", "ERRFRAME", "BUSLOAD", "IDFILTER", "LISTONLY", "SCHEDULER",
                        "DELAYEDTX", "SINGLESHOT", "HIGHPRIOR", "AUTOBAUD"):  # fmt: skip
            assert caps.features & getattr(vci, f"CAN_FEATURE_{feature}"), feature
        for feature in ("GENERRFRM", "EXTDATA", "FASTDATA", "ISOFRAME", "NONISOFRM", "64BITTSC"):
            assert not caps.features & getattr(vci, f"CAN_FEATURE_{feature}"), feature


@pytest.mark.conforms("X4-14")
def test_capabilities_of_an_fd_line() -> None:
    caps = capabilities2_of(USB_TO_CAN_FD)
    for feature in ("EXTDATA", "FASTDATA", "ISOFRAME", "NONISOFRM"):
        assert caps.features & getattr(vci, f"CAN_FEATURE_{feature}"), feature
        assert not capabilities_of(USB_TO_CAN_FD).features & getattr(vci, f"CAN_FEATURE_{feature}"), feature
    raw = vci.CAN_BTMODE_RAW
    assert caps.can_clk_freq == 80_000_000
    assert caps.sdr_range_min == vci.CanBtp(raw, 2, 1, 1, 1)
    assert caps.sdr_range_max == vci.CanBtp(raw, 513, 256, 256, 128)
    assert caps.fdr_range_max == vci.CanBtp(raw, 513, 256, 256, 128, 255)
    assert capabilities2_of(USB_TO_CAN).fdr_range_max == vci.CanBtp()


@pytest.mark.conforms("X4-14")
@pytest.mark.parametrize("capabilities", [USB_TO_CAN, USB_TO_CAN_FD], ids=["classic", "fd"])
def test_both_tell_the_same_ticks(capabilities: canwire.Capabilities) -> None:
    one, two = capabilities_of(capabilities), capabilities2_of(capabilities)
    for timer in ("tsc", "cms", "dtx"):
        divisor, clock = getattr(two, f"{timer}_divisor"), getattr(two, f"{timer}_clk_freq")
        assert getattr(one, f"{timer}_divisor") * clock == divisor * one.clock_freq
    assert (one.cms_max_ticks, one.dtx_max_ticks) == (two.cms_max_ticks, two.dtx_max_ticks)
    none = dataclasses.replace(capabilities, cyclic=canwire.Ticks())
    assert (capabilities_of(none).cms_divisor, capabilities_of(none).cms_max_ticks) == (0, 0)
