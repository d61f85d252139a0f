"""What the manuals' pages say of differences, and the tests that show each row.

A row's proof is `file::test another_test file::test`, the file without .py, the test without test_.
"""

from __future__ import annotations

from typing import NamedTuple

CONNECTOR, HEARING = "boards/can/test_connector", "together/test_hearing"
MENDED, GUIDE = "candrv/test_findings", "docs/test_porting_candrv"


class Page(NamedTuple):
    """A page of docs/, its section of differences, and the proofs of the rows of the section's tables."""

    file: str
    section: str
    proofs: dict[str, str]
    """By the row's first cell."""


VCI = {
    "figures": "docs/test_differences_vci::figures",
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
    "`ICanStatus`, `ICanObject`": "docs/test_differences_vci::interfaces_of_the_headers_alone",
    "LIN": "vci/lin/test_data::status_bits_are_told_apart",
    "GUIDs of device classes": "vci/test_guids::the_vendors_names names_that_canwire_had_first_go_on_working",
    "`CAN_MSGTYPE_STATUS`": "vci/can/test_messages::every_change_of_state_is_told the_status_told_is_that_of_the_line "
    "a_fault_of_the_coupling_comes_and_goes_with_a_message",
    "`InitLine`": "vci/can/test_control::init_line_resets_what_others_see",
    "the cyclic list of a stopped line": "vci/can/test_scheduler::what_a_stopped_line_did_not_send_never_comes",
    "boards without a processor": "vci/can/test_scheduler::a_passive_board_has_no_list",
    "`QueryInterface`": "vci/fifo/test_interfaces::a_channels_fifos_can_be_looked_at",
    "`DetectBaud` with `CAN_OPMODE_LOWSPEED`": "vci/can/test_detect::the_manuals_table_at_low_speed",
    "timings": "vci/can/test_line::only_a_can_fd_controller_may_jump_as_far_as_tseg2_is_long",
    "`dlc` 9 to 15": "docs/test_differences_vci::a_classic_message_with_a_dlc_beyond_8",
    "`AddFilterIds` on a filter of size 0": "vci/can/test_filters::"
    "without_room_there_is_no_list_but_an_acceptance_filter",
    "events": "docs/test_differences_vci::a_signalled_event_loses_its_signal_with_its_fifo",
    "names of the headers that no manual has": "docs/test_differences_vci::names_that_are_missing",
    "timing on the wire": "docs/test_porting_vci::ticks_are_seconds",
    "`ActivateSecondExclusive`": "vci/v3/can/test_channel::an_exclusive_channel_is_alone "
    "vci/net4/test_lines::an_exclusive_channel_is_alone",
    "`ChannelStatusBeforeInit`": "vci/v3/can/test_channel::before_it_is_initialised_a_channel_can_do_nothing "
    "vci/net4/test_lines::before_initialize_a_channel_has_no_status "
    "vci/can/test_channels::before_it_is_initialised_a_channel_can_do_nothing",
    "`StatusPropertyTests`": "vci/v3/can/test_scheduler::states_change_with_update_status_only "
    "vci/net4/test_lines::a_message_is_started_and_stopped_by_itself",
    "`CurrentSameResultForMultiCall`": "vci/v3/test_devices::objects_of_the_same_board_are_equal",
    "`Threshold` of a disposed reader or writer": "vci/v3/can/test_channel::"
    "a_disposed_end_counts_nothing_and_does_nothing",
    "`UpdateStatus` of a disposed list": "vci/v3/can/test_scheduler::a_disposed_list_is_gone "
    "vci/net4/test_lines::a_disposed_list_is_gone",
    "`AutoRate` for a LIN master": "docs/test_differences_vci::a_lin_master_has_a_rate",
    "`Inc16` or `Inc8` on bytes that are not sent": "vci/v3/can/test_scheduler::messages_that_no_line_can_send "
    "vci/net4/test_lines::counting_in_bytes_that_are_not_sent",
    "`VciBusType.FlexRay`": "vci/v3/test_enums::members vci/net4/test_names::every_value_is_the_contracts",
    "`CanMsgError.Other`": "vci/v3/test_enums::members vci/net4/test_names::every_value_is_the_contracts",
    "`Current` before the first board and after the last": "vci/v3/test_devices::"
    "before_the_first_and_behind_the_last_there_is_no_current",
}

CANDRV = {
    "table 10: mode and format decide what is accepted": f"{MENDED}::reception_follows_the_mode_alone",
    "the registry's AcceptanceCode 0, AcceptanceMask 0": "candrv/test_filters::the_defaults_accept_identifier_0_only "
    "candrv/test_handle::the_default_filter_accepts_identifier_0_only "
    f"{MENDED}::a_registry_s_filter_means_any_data_unless_it_names_some",
    "DEVICE_CHANGED": f"{HEARING}::each_hears_what_it_asked_for "
    f"{CONNECTOR}::a_stop_and_a_reset_are_changes_that_say_so",
    "INIT, SET_CAN_MODE beside programs of other interfaces": f"{HEARING}::candrvs_init_leaves_vcis_settings_alone "
    "vcis_start_leaves_candrvs_mode_alone",
    "data bytes in filters, bits 15..0": "candrv/test_filters::example_1_of_8_11 a_filter_accepts_what_the_tables_say "
    f"{MENDED}::a_filter_may_ask_for_data_of_zeros boards/can/test_channel::a_byte_that_is_not_there_is_no_zero",
    "SET_DEFAULT_FRAME_FORMAT": f"{MENDED}::a_format_leaves_the_controller_alone",
    "SET_BAUDRATE, SET_CAN_MODE, INIT during traffic": "candrv/test_differences::"
    "settings_amid_traffic_leave_no_message_without_its_outcome "
    f"{CONNECTOR}::initialised_anew_in_the_middle_of_everything",
    'SELF_RECEPTION_REQUEST "can only receive its own messages"': f"{MENDED}::loop_back_stays_until_init "
    "candrv/test_ioctl::loop_back_needs_no_partner",
    "NetDCU in CAN2.0A": f"{MENDED}::all_commands_in_both_modes",
    "a command that `CAN_PROPERTIES` does not list": "candrv/test_ioctl::unlisted_commands_are_refused",
    "virtual channels, 7.3": f"{GUIDE}::three_channels_to_send_and_two_to_receive",
    "share mode: 1 read, 2 write": f"{GUIDE}::with_share_mode_0_each_program_keeps_the_device_to_itself "
    "candrv/test_handle::share_modes",
    "dwCreation OPEN_EXISTING": f"candrv/test_pointers::creation {MENDED}::device_names_in_either_case",
    "VIRTUALIZE": f"{MENDED}::two_programs_on_one_board_alone candrv/test_handle::virtualize",
    "a rate between min and max": f"{GUIDE}::a_rate_that_the_clock_does_not_make_is_refused "
    "candrv/test_differences::a_registrys_rate_that_the_clock_does_not_make_opens_no_device",
    "Order, Dll, Ioctl, Priority256, IRQ": "candrv/registry/test_registry::what_the_virtual_board_ignores_says_so "
    "devices_in_ascending_order impossible_values",
    "registry entries act after a restart": "candrv/test_handle::settings_act_when_the_driver_is_loaded_again",
    "a rate set by SET_BAUDRATE": "candrv/test_handle::a_rate_set_by_one_handle_stays_for_the_next",
    "an unplugged board": f"{MENDED}::a_board_that_was_pulled_out_has_one_code",
    "CloseHandle": "candrv/test_handle::closing_sends_what_is_left closing_gives_up_where_nothing_moves",
    "CAN time": "candrv/test_differences::can_time_starts_with_the_hub",
    "events beyond EventQueueSize (200)": "candrv/test_handle::a_full_queue_counts_what_it_loses",
    "the MCP2515 in bus-off": "candrv/test_differences::an_mcp2515_in_bus_off_reads_0_until_init",
    "`-b 500k` of the tools": "commands/candrv/test_verb::usage",
    "the tools' usage": "commands/candrv/test_verb::usage the_hub_goes",
    "dlc 9 to 15": "candrv/test_handle::dlc_above_8_is_transferred_as_set",
}

ACAN = {
    "an unregistered block makes `ACAN_AckEvent` unpredictable": "acan/test_api::registration_is_checked",
    "a block that is not deregistered crashes the system": "acan/test_processes::"
    "a_program_that_dies_leaves_the_line_set_up_and_nothing_behind",
    "the driver writes into memory at interrupt time; FIXED memory": "acan/test_api::"
    "messages_may_lie_packed_in_fixed_memory fixed_memory_is_zero_and_freed_once",
    "`lpBuf` is memory; `bNId` counts filters": "acan/test_api::messages_may_lie_packed_in_fixed_memory "
    "messages_come_in_order_with_their_bits_aligned "
    "acan/test_structures::filters_count_themselves_unless_told_otherwise",
    "`hwnd`, `nMsg`; `wTid`, `wEvent` of ADTM": "acan/test_api::notification_by_posted_message "
    "acan/test_int2d::ms_dos_knows_only_events what_the_driver_updates_appears_in_memory",
    'SJW "forced between 0 and 3"': "acan/test_hard_config::sjw_is_forced_into_bounds",
    "filters: AND, then equal to XOR, no RTR": "acan/test_task_block::identifiers_are_left_aligned_in_filters "
    "a_filter_takes_data_and_remote_frames_alike",
    "AMR = `hi_mim >> 13` and so on": "acan/test_hard_config::masks_are_inverted_and_the_top_sixteen_bits_counted",
    "`SC_NOBUFF` under Windows only": "acan/test_driver::answers_that_find_no_room_are_told_as_missing_buffers "
    "frames_that_nobody_fetched_in_time_are_told_as_missing_buffers",
    '`/I:5*` shares the interrupt, the board "can not"': "boards/test_isa::a_shared_interrupt_line "
    "one_interrupt_line_for_two",
    'vendor "At on Sys" of 8 characters, a "16-bytes string"': "acan/test_int2d::the_check_answers_with_the_signature",
    "fields 'R' of a Task Block over INT 2Dh": "acan/test_int2d::what_the_driver_updates_appears_in_memory",
    "`hi_ien` without EIE or EPIE": "acan/test_dispatch::limits_are_told_by_their_interrupts",
    "`hi_ocr` with outputs that float, 0 perhaps": "boards/test_transceiver::"
    "nobody_hears_it_and_it_gets_no_acknowledge it_hears_others_and_acknowledges_nobody",
    "counters in bus-off": "acan/test_dispatch::in_bus_off_the_counter_is_the_chips",
    "`ACAN_SendMessage` before `ACAN_SetHardConfig`, off the bus or in bus-off": "acan/test_api::"
    "a_virgin_controller_takes_messages_and_bus_on_gives_them_up acan/test_driver::"
    "going_on_the_bus_gives_up_what_was_queued_before bus_off_is_told_and_bus_on_begins_anew "
    f"{HEARING}::acan_begins_again_off_the_bus",
    "one notification a message": "acan/test_driver::a_burst_is_told_of_together_and_nothing_is_lost",
    "`hEvent` filled in by the DLL": "acan/test_api::register_fills_the_event_in",
    "`hi_hsb[2..7]` reserved": "acan/test_api::reserved_bytes_of_the_configuration_are_given_back_as_0",
    "`ACAN.H` in one piece": "test_star_imports::a_star_import_of_acans_library_is_its_header",
    "multiplex number": "acan/test_int2d::multiplex_numbers_are_bytes_and_not_0",
    "length of the cable": "acan/test_cable::a_cables_delay_is_that_of_the_bus_s_rate_and_length",
    "the LED of the bracket": "boards/test_inducan104::the_led_is_the_interrupt",
    "SYSTEM.INI, WCT.INI": "commands/acan/test_term::installation "
    "commands/acan/test_wct::a_file_in_the_windows_code_page_keeps_its_bytes",
    "SC_BUSOFF": f"{HEARING}::each_hears_what_it_asked_for {CONNECTOR}::a_stop_and_a_reset_are_changes_that_say_so",
    "`hi_miv`, `hi_ien`": f"{HEARING}::each_hears_what_it_asked_for acan/test_driver::"
    f"the_chip_is_programmed_as_the_manual_says {CONNECTOR}::a_mode_says_for_its_own_kin_what_is_heard",
    "ACAN and other drivers": "together/test_matrix::cells",
}

DONGLE = {
    "the answer to t and T": "slcan/test_dongle::sending the_short_reply",
    '"must wait for an answer" before the next command': "slcan/test_dongle::how_a_session_starts sending",
    "S7": "slcan/test_dongle::standard_rates",
    "RTR frames": "slcan/test_dongle::sending slcan/test_hub_port::listening_neither_acknowledges_nor_sends",
    "hex digits": "slcan/test_dongle::digits_are_read_in_either_case_and_answered_in_capitals",
    'which frames are "in the transmit queue"': "slcan/test_hub_port::"
    "eight_frames_wait_for_a_bus_that_nobody_else_is_on "
    "slcan/test_dongle::the_ninth_frame_is_refused",
    "when frames are lost": "slcan/test_dongle::the_thirty_third_received_frame_is_lost",
    "replies for a host that reads nothing": "slcan/test_dongle::a_host_that_never_reads_blocks_nothing",
    "flags": "slcan/test_dongle::flags_wait_for_the_next_opening flags_of_error_states",
    "C": "slcan/test_hub_port::closing_goes_off_the_bus_at_once slcan/test_dongle::closing_gives_up_what_waits",
    "the time stamp's zero": "slcan/test_hub_port::stamps_count_from_power_up slcan/test_dongle::time_stamps",
    "BELL for T with more than 29 bits": "slcan/test_dongle::identifiers_of_more_than_29_bits",
    "a remote frame without a length": "slcan/test_dongle::a_remote_frame_without_a_length_asks_for_none",
    "a pseudo terminal that no program has open": "slcan/test_wires::a_client_finds_the_terminal_raw_and_empty",
    "TCP": "slcan/test_wires::tcp_serves_one_at_a_time",
    "EEPROM": "slcan/test_dongle::stamping_is_remembered",
    "the speed of the line": "slcan/test_pace::without_a_rate_all_comes_at_once commands_come_one_by_one",
    "other programs on the hub": "slcan/test_hub_port::nobody_else_sets_its_line_up",
}

PAGES = {
    "VCI": Page("porting-vci.md", "Differences from real boards", VCI),
    "CANDRV": Page("porting-candrv.md", "Differences from real boards", CANDRV),
    "ACAN": Page("porting-acan.md", "Differences from real boards", ACAN),
    "the dongle": Page("slcan.md", "Differences from a real dongle", DONGLE),
}
