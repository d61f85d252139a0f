"""What docs/porting-vci.md says of differences is true: each row of its two tables has tests, here or elsewhere.

`PROOFS` names them; a row without one, a proof without its row and a test that is no more fail.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import vci
from canwire.vci import v3
from canwire.vci.fifo.elements import Plain
from tests.cases import hold_for_each
from tests.vci.fifo.test_fifo import Pair

TESTS = Path(__file__).resolve().parents[1]
PAGE = TESTS.parent / "docs" / "porting-vci.md"
HERE = "docs/test_differences_vci"
PROOFS = {  # the row's first cell: file::test, without .py and test_
    "figures": f"{HERE}::figures",
    "time stamps": "vci/can/test_messages::times_of_information",
    "a channel's FIFOs": "vci/fifo/test_fifo::canmsgs_to_write_do_not_lie_side_by_side canmsg_lies_in_cells_of_canmsg2",
    "a reader's elements": "vci/fifo/test_in_place::a_readers_element_is_its_own_and_may_be_kept "
    "an_element_dies_with_its_block_and_a_copy_does_not",
    "CAN FD on a classic controller": "vci/can/test_channels::a_classic_controller_refuses_can_fd_aloud",
    "`CAN_INFO_STOP`, `CAN_INFO_RESET`": "contracts/test_line::what_is_told_of_starting_stopping_and_resetting "
    "boards/can/test_connector::their_bytes",
    "`ResetLine`": "vci/can/test_control::states reset_clears_filters fifos_keep_what_is_in_them "
    "vci/v3/can/test_control::after_a_reset_the_line_starts_with_its_last_settings "
    "vci/net4/test_lines::after_a_reset_the_line_is_offline_with_its_settings",
    "`DetectBaud`": "vci/can/test_detect::what_detect_refuses low_speed_is_asked_for_in_the_index",
    "self-reception": "vci/can/test_channels::who_gets_self_receptions with_srra_ones_own_come_back_marked",
    "`ovr`": "vci/can/test_messages::the_first_message_after_lost_ones_says_so",
    "the cyclic list": "vci/can/test_scheduler::until_resume_nothing_is_sent collisions_take_the_next_free_slot "
    "vci/net4/test_lines::a_message_is_started_and_stopped_by_itself",
    "the 11-bit list": "vci/can/test_filters::the_11_bit_list_has_room_for_all",
    "names": "vci/structures/test_constants::can_constants vci/v3/test_names::every_member_has_its_counterpart",
    "`CANMSG2`": "vci/structures/test_structures::layout",
    "`VciFormatError`": "vci/structures/test_errors::codes_and_their_text",
    "`ICanStatus`, `ICanObject`": f"{HERE}::interfaces_of_the_headers_alone",
    "LIN": "vci/lin/test_data::status_bits_are_told_apart",
    "GUIDs of device classes": "vci/test_guids::the_vendors_names names_that_canwire_had_first_go_on_working",
    "`CAN_MSGTYPE_STATUS`": "vci/can/test_messages::every_change_of_state_is_told the_status_told_is_that_of_the_line "
    "a_fault_of_the_coupling_comes_and_goes_with_a_message",
    "`InitLine`": "vci/can/test_control::init_line_resets_what_others_see",
    "the cyclic list of a stopped line": "vci/can/test_scheduler::what_a_stopped_line_did_not_send_never_comes",
    "boards without a processor of their own": "vci/can/test_scheduler::a_passive_board_has_no_list",
    "`QueryInterface`": "vci/fifo/test_interfaces::a_channels_fifos_can_be_looked_at",
    "`DetectBaud` with `CAN_OPMODE_LOWSPEED`": "vci/can/test_detect::the_manuals_table_at_low_speed",
    "timings": "vci/can/test_line::only_a_can_fd_controller_may_jump_as_far_as_tseg2_is_long",
    "`dlc` 9 to 15": f"{HERE}::a_classic_message_with_a_dlc_beyond_8",
    "`AddFilterIds` on a filter of size 0": "vci/can/test_filters::"
    "without_room_there_is_no_list_but_an_acceptance_filter",
    "events": f"{HERE}::a_signalled_event_loses_its_signal_with_its_fifo",
    "names of the headers that no manual has": f"{HERE}::names_that_are_missing",
    "timing on the wire": "docs/test_porting_vci::ticks_are_seconds",
    "`ActivateSecondExclusive`": "vci/v3/can/test_channel::an_exclusive_channel_is_alone "
    "vci/net4/test_lines::an_exclusive_channel_is_alone",
    "`StatusPropertyTests`": "vci/v3/can/test_scheduler::states_change_with_update_status_only "
    "vci/net4/test_lines::a_message_is_started_and_stopped_by_itself",
    "`CurrentSameResultForMultiCall`": "vci/v3/test_devices::objects_of_the_same_board_are_equal",
    "`Threshold` of a disposed reader or writer": "vci/v3/can/test_channel::"
    "a_disposed_end_counts_nothing_and_does_nothing",
    "`UpdateStatus` of a disposed list": "vci/v3/can/test_scheduler::a_disposed_list_is_gone "
    "vci/net4/test_lines::a_disposed_list_is_gone",
    "`AutoRate` for a LIN master": f"{HERE}::a_lin_master_has_a_rate",
    "`Inc16` or `Inc8` on bytes that are not sent": "vci/v3/can/test_scheduler::messages_that_no_line_can_send "
    "vci/net4/test_lines::counting_in_bytes_that_are_not_sent",
    "`VciBusType.FlexRay`": "vci/v3/test_enums::members vci/net4/test_names::every_value_is_the_contracts",
    "`CanMsgError.Other`": "vci/v3/test_enums::members vci/net4/test_names::every_value_is_the_contracts",
    "`Current` before the first board and behind the last": "vci/v3/test_devices::"
    "before_the_first_and_behind_the_last_there_is_no_current",
}


def rows() -> list[str]:
    """First cells of the section's tables."""
    text = PAGE.read_text(encoding="utf-8")
    [section] = re.findall(r"^## Differences from real boards\n(.*?)^## ", text, re.MULTILINE | re.DOTALL)
    cells = [
        line.split(" | ")[0].removeprefix("| ") for line in section.splitlines() if line.startswith("| ")
    ]
    return [cell for cell in cells if cell not in ("what", "test")]


def proofs(text: str) -> Iterator[tuple[Path, str]]:
    file = ""
    for word in text.split():
        before, _, name = word.rpartition("::")
        file = before or file
        yield TESTS / f"{file}.py", f"test_{name}"


def test_each_row_has_its_proof_and_each_proof_its_row() -> None:
    assert sorted(rows()) == sorted(PROOFS)


def test_each_proof_is_a_test() -> None:
    def check(row: str) -> None:
        found = list(proofs(PROOFS[row]))
        assert found
        for file, name in found:
            tree = ast.parse(file.read_text(encoding="utf-8"))
            assert name in {one.name for one in tree.body if isinstance(one, ast.FunctionDef)}, (
                f"{file}: {name}"
            )

    hold_for_each(PROOFS, check)


# what no other test shows


@pytest.fixture
def bal() -> Iterator[Any]:
    """The access layer of a USB-to-CAN FD, on a hub in virtual time."""
    with canwire.connect(time="virtual") as hub:
        vci.initialize(hub)
        with vci.query_device_by_class(vci.GUID_USB2CANFD_DEVICE) as device:
            yield device.open_component(vci.CLSID_VCIBAL, vci.IID_IBalObject)


def test_figures(bal: Any) -> None:
    caps = bal.open_socket(0, vci.IID_ICanSocket2).get_capabilities()
    assert caps.can_clk_freq == 80_000_000
    assert caps.tsc_divisor / caps.tsc_clk_freq == 1e-6
    assert caps.cms_divisor / caps.cms_clk_freq == caps.dtx_divisor / caps.dtx_clk_freq == 100e-6
    assert caps.cms_max_ticks == caps.dtx_max_ticks == 65_535


def test_interfaces_of_the_headers_alone(bal: Any) -> None:
    for iid in (vci.IID_ICanStatus, vci.IID_ICanObject):
        with pytest.raises(vci.VciNotImplemented):
            bal.open_socket(0, iid)


def test_a_classic_message_with_a_dlc_beyond_8(bal: Any) -> None:
    ends = []
    for connector in (0, 1):
        channel = bal.open_socket(connector, vci.IID_ICanSocket).create_channel()
        channel.initialize(10, 10)
        channel.activate()
        control = bal.open_socket(connector, vci.IID_ICanControl)
        init = vci.CanInitLine(vci.CAN_OPMODE_STANDARD, 0, vci.CAN_BT0_500KB, vci.CAN_BT1_500KB)
        control.init_line(init)
        control.start_line()
        ends.append(channel)
    event, reader = canwire.Event(), ends[1].get_reader()
    reader.assign_event(event)
    ends[0].get_writer().put_data_entry(vci.CanMsg(msg_id=1, data=b"12345678", dlc=15))
    message = vci.CanMsg(type=vci.CAN_MSGTYPE_INFO)
    while message.msg_info.type != vci.CAN_MSGTYPE_DATA:
        assert reader.get_fill_count() or event.wait(1.0)
        message = reader.get_data_entry()
    assert (message.msg_info.dlc, message.data) == (15, b"12345678")


@pytest.mark.parametrize("released", [False, True], ids=["taken off", "reader released"])
def test_a_signalled_event_loses_its_signal_with_its_fifo(released: bool) -> None:
    pair, event = Pair(Plain(4)), canwire.Event()
    pair.reader.assign_event(event)
    pair.fill(1)
    assert event.is_set()
    if released:
        pair.reader.release()
    else:
        pair.reader.assign_event(None)
    assert not event.is_set()
    event.close()


def test_names_that_are_missing() -> None:
    missing = ("CAN_BITRATE_500KB", "CAN_BT01_500KB", "VCI_E_WRONG_FLASHFWVERSION", "can_bt0_get_brp")
    assert [name for name in missing if hasattr(vci, name)] == []


def test_a_lin_master_has_a_rate(bal: Any) -> None:
    device = next(iter(v3.VciServer.get_device_manager().get_device_list()))
    with device, device.open_bus_access_layer() as layer, layer.open_socket(2, v3.LinControl) as control:
        assert control.supports_autorate
        init = v3.LinInitLine(v3.LinOperatingModes.MASTER, v3.LinBitrate.AUTO_RATE)
        with pytest.raises(v3.ArgumentException):
            control.init_line(init)
        control.init_line(v3.LinInitLine(v3.LinOperatingModes.SLAVE, v3.LinBitrate.AUTO_RATE))
