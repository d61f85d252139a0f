"""Finding the bit rate of a running bus by listening alone."""

from __future__ import annotations

from typing import Any

import pytest

from canwire import vci
from tests.vci.programs import Program, Virtual

BOTH = vci.CAN_OPMODE_STANDARD | vci.CAN_OPMODE_EXTENDED
CLASSIC_BOARD = "HW000002"
RATES = [10, 20, 50, 100, 125, 250, 500, 800, 1000]
FD = vci.CAN_EXMODE_EXTDATA | vci.CAN_EXMODE_FASTDATA
TIMEOUT_MS = 200


def old_table(*kbit: int) -> vci.CanBtrTable:
    registers = [[getattr(vci, f"CAN_BT{number}_{rate}KB") for rate in kbit] for number in (0, 1)]
    return vci.CanBtrTable(len(kbit), 0xFF, *map(bytes, registers))


def new_table(*pairs: tuple[vci.CanBtp, vci.CanBtp]) -> vci.CanBtpTable:
    return vci.CanBtpTable(len(pairs), 0xFF, [vci.CanBtpPair(*pair) for pair in pairs])


class Traffic:
    """Two lines of the FD board that speak to each other, one message every millisecond."""

    def __init__(self, program: Program, **members: Any) -> None:
        self.ports = [program.port(line, rx=2000) for line in (0, 1)]
        for line in (0, 1):
            program.start(line, op_mode=BOTH | vci.CAN_OPMODE_ERRFRAME, **members)
        fd = "ex_mode" in members
        scheduler = program.open(vci.IID_ICanScheduler2)
        bits = {"edl": 1, "fdr": 1} if fd else {}
        data = bytes(range(16 if fd else 8))
        scheduler.start_message(
            scheduler.add_message(vci.CanCyclicTxMsg2(cycle_time=10, msg_id=0x155, data=data, **bits)), 0
        )
        scheduler.resume()
        self.ports[1].message()

    def errors(self) -> list[Any]:
        found = [one for port in self.ports for one in port.waiting()]
        return [one for one in found if one.msg_info.type == vci.CAN_MSGTYPE_ERROR]


@pytest.mark.conforms("X3-12", "X4-22")
@pytest.mark.parametrize("kbit", [50, 125, 500, 1000])
@pytest.mark.parametrize("index", [0, 0xFF])
def test_the_rate_of_a_running_bus(program: Program, kbit: int, index: int) -> None:
    traffic = Traffic(program, btp_sdr=getattr(vci, f"CAN_BTP_{kbit}KB"))
    control = program.control(0, CLASSIC_BOARD, vci.IID_ICanControl)
    table = old_table(*RATES)
    table.index = index
    found = control.detect_baud(TIMEOUT_MS, table)
    assert found is table
    assert table.index == RATES.index(kbit)
    assert traffic.errors() == []
    registers = (table.btr0[table.index], table.btr1[table.index])
    control.init_line(vci.CanInitLine(BOTH, 0, *registers))
    control.start_line()
    listener = program.old_port(0, CLASSIC_BOARD)
    assert listener.message().msg_id == 0x155
    assert traffic.errors() == []


@pytest.fixture
def third_line(hub: Any) -> Any:
    """Hardware id of another FD board."""
    board = hub.plug("usb-to-can-fd", "HW333333")
    yield board.hardware_id
    hub.unplug(board.hardware_id)


@pytest.mark.conforms("X4-22")
def test_both_rates_of_a_running_bus(program: Program, third_line: str) -> None:
    traffic = Traffic(program, ex_mode=FD, btp_sdr=vci.CAN_BTP_250KB, btp_fdr=vci.CAN_BTP_DBR_LL_1000KB)
    fast = [vci.CAN_BTP_DBR_SL_2000KB, vci.CAN_BTP_DBR_LL_1000KB, vci.CAN_BTP_DBR_SL_4000KB]
    table = new_table(*((slow, one) for slow in (vci.CAN_BTP_500KB, vci.CAN_BTP_250KB) for one in fast))
    control = program.control(0, third_line)
    assert control.detect_baud(0, vci.CAN_EXMODE_FASTDATA, TIMEOUT_MS, table).index == 4
    assert traffic.errors() == []


@pytest.mark.conforms("X3-12", "X4-22")
def test_a_silent_bus(program: Program) -> None:
    control = program.control(0, CLASSIC_BOARD, vci.IID_ICanControl)
    with pytest.raises(vci.VciTimeout):
        control.detect_baud(5, old_table(500, 250))
    two = program.control(1, CLASSIC_BOARD)
    with pytest.raises(vci.VciTimeout):
        two.detect_baud(0, 0, 5, new_table((vci.CAN_BTP_500KB, vci.CAN_BTP_EMPTY)))


@pytest.mark.conforms("X3-12")
def test_a_rate_that_is_not_in_the_table(program: Program) -> None:
    traffic = Traffic(program)
    control = program.control(0, CLASSIC_BOARD, vci.IID_ICanControl)
    with pytest.raises(vci.VciTimeout):
        control.detect_baud(20, old_table(100, 125, 250, 1000))
    assert traffic.errors() == []


@pytest.mark.conforms("X4-22")
def test_what_detect_refuses(program: Program) -> None:
    old, new = program.control(0, CLASSIC_BOARD, vci.IID_ICanControl), program.control(1, CLASSIC_BOARD)
    slow = (vci.CAN_BTP_500KB, vci.CAN_BTP_DBR_SL_2000KB)
    for wrong in (old_table(), vci.CanBtrTable(65, 0), new_table(slow)):
        with pytest.raises(vci.VciInvalidArgument):
            old.detect_baud(10, wrong)
    table = old_table(500)
    table.index = 1
    with pytest.raises(vci.VciInvalidArgument, match="bIndex"):
        old.detect_baud(10, table)
    for timeout in (-1, 65536):
        with pytest.raises(vci.VciInvalidArgument, match="timeout_ms"):
            old.detect_baud(timeout, old_table(500))
    with pytest.raises(vci.VciTimeout):
        old.detect_baud(0, old_table(500))
    with pytest.raises(vci.VciNotSupported, match="CAN_FEATURE_FASTDATA"):
        new.detect_baud(0, vci.CAN_EXMODE_FASTDATA, 10, new_table(slow))
    with pytest.raises(vci.VciError, match=r"asBTP\[1\]") as raised:
        new.detect_baud(0, 0, 10, new_table(slow, (vci.CanBtp(0, 777_777, 7, 1, 1), vci.CAN_BTP_EMPTY)))
    assert raised.value.code == vci.VCI_E_INVALID_TIMING


@pytest.mark.conforms("X4-22")
def test_tables_of_64_entries(program: Program) -> None:
    traffic = Traffic(program)
    table = old_table(*[250] * 63, 500)
    assert program.control(0, CLASSIC_BOARD, vci.IID_ICanControl).detect_baud(TIMEOUT_MS, table).index == 63
    assert traffic.errors() == []


@pytest.mark.conforms("X4-22")
def test_a_running_line_does_not_search(program: Program) -> None:
    control = program.control(0, CLASSIC_BOARD, vci.IID_ICanControl)
    control.init_line(vci.CanInitLine(BOTH, 0, vci.CAN_BT0_500KB, vci.CAN_BT1_500KB))
    control.start_line()
    with pytest.raises(vci.VciInvalidState):
        control.detect_baud(10, old_table(500))


@pytest.mark.conforms("X4-43")
def test_low_speed_is_asked_for_in_the_index(program: Program) -> None:
    traffic = Traffic(program, btp_sdr=vci.CAN_BTP_100KB)
    table = old_table(125, 100)
    table.index = vci.CAN_OPMODE_LOWSPEED
    control = program.control(0, CLASSIC_BOARD, vci.IID_ICanControl)
    assert control.detect_baud(TIMEOUT_MS, table).index == 1
    assert traffic.errors() == []


@pytest.mark.conforms("X4-43", "X4-23")
@pytest.mark.finding("vci F7")
def test_the_manuals_table_at_low_speed(program: Program) -> None:
    """Entries that the coupling cannot have are passed over."""
    Traffic(program, btp_sdr=vci.CAN_BTP_100KB)
    rates = [10, 20, 50, 100, 125, 250, 500, 800, 1000]
    table = old_table(*rates)
    table.index = vci.CAN_OPMODE_LOWSPEED
    old = program.control(0, CLASSIC_BOARD, vci.IID_ICanControl)
    assert old.detect_baud(TIMEOUT_MS, table).index == rates.index(100)
    table = old_table(1000, 500, 100)
    table.index = vci.CAN_OPMODE_LOWSPEED
    assert old.detect_baud(TIMEOUT_MS, table).index == 2
    too_fast = old_table(1000, 500)
    too_fast.index = vci.CAN_OPMODE_LOWSPEED
    with pytest.raises(vci.VciTimeout):
        old.detect_baud(TIMEOUT_MS, too_fast)


@pytest.mark.conforms("X4-43", "X4-15")
def test_low_speed_needs_that_coupling(program: Program) -> None:
    old = program.control(0, iid=vci.IID_ICanControl)
    table = old_table(100)
    table.index = vci.CAN_OPMODE_LOWSPEED
    with pytest.raises(vci.VciNotSupported, match="CAN_BUSC_LOWSPEED"):
        old.detect_baud(10, table)
    with pytest.raises(vci.VciNotSupported, match="CAN_BUSC_LOWSPEED"):
        program.control(1).detect_baud(
            vci.CAN_OPMODE_LOWSPEED, 0, 10, new_table((vci.CAN_BTP_100KB, vci.CAN_BTP_EMPTY))
        )


@pytest.mark.conforms("X4-23")
@pytest.mark.parametrize("iid", [vci.IID_ICanControl, vci.IID_ICanControl2])
def test_autobaud(program: Program, iid: Any) -> None:
    traffic = Traffic(program, btp_sdr=vci.CAN_BTP_250KB)
    control = program.control(0, CLASSIC_BOARD, iid)
    op_mode = BOTH | vci.CAN_OPMODE_AUTOBAUD
    old = iid == vci.IID_ICanControl
    control.init_line(vci.CanInitLine(op_mode) if old else vci.CanInitLine2(op_mode))
    control.start_line()
    port = program.port(0, CLASSIC_BOARD)
    assert port.message().msg_id == 0x155
    assert control.get_line_status().op_mode == op_mode
    assert traffic.errors() == []


@pytest.mark.conforms("X4-23")
def test_autobaud_on_a_silent_bus(virtual: Virtual) -> None:
    control = virtual.program.control(0, CLASSIC_BOARD)
    with pytest.raises(vci.VciTimeout):
        control.init_line(vci.CanInitLine2(BOTH | vci.CAN_OPMODE_AUTOBAUD))
    with pytest.raises(vci.VciNotInitialized):
        control.start_line()
