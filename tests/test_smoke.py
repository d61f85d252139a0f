"""What README promises, and the test that shows it in a moment: `python -m pytest -m smoke` runs these."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PROMISES = {  # words of README: a test with the marker `smoke`
    "arbitration, acknowledge, exact bit times, error frames": "docs/test_readme.py::test_three_lines_to_a_bus",
    "error passive, bus-off": "bus/can/test_errors.py::test_32_disturbed_attempts_lead_to_bus_off",
    "in real time or many times faster": "lab/test_real_time.py::test_frames_arrive",
    "the same script gives the same bytes every time": "test_core_mode.py::test_other_seeds_do_something_else",
    "Play a real car's log onto a simulated bus": "docs/test_readme.py::test_a_log_on_a_simulated_bus",
    "without a C compiler everything works": "test_core_mode.py::test_the_twin_is_another_copy_and_interpreted",
    "pytest has three fixtures": "docs/test_readme.py::test_in_your_tests",
    "One process keeps the boards, and other programs use them": "docs/test_readme.py::test_shared_boards",
    "a program that crashes does no harm": "hub/test_kills.py::test_others_notice_nothing_of_a_client_that_dies",
    "`canwire web --open` shows the same boards": "web/test_page.py::test_readers_get_every_view",
    "Programs written for IXXAT's VCI": "docs/test_porting_vci.py::test_the_first_program",
    ".NET's V3": "vci/v3/test_samples.py::test_single_messages",
    'can.Bus(interface="canwire"': "python_can/test_bus.py::test_programs_on_one_line_hear_each_other",
    "the INduCAN104 and its ACAN driver": "acan/test_api.py::test_messages_are_sent",
    "F&S's CANDRV": "candrv/test_win32.py::test_can_write_and_can_read",
    "`canwire run candump can0`": "socketcan/test_candump.py::test_its_lines_are_those_of_canwire_dump",
    "`canwire serve --dongle`": "commands/test_serve_dongle.py::test_a_hub_with_a_dongle",
    "five programs for five interfaces": "docs/test_five_programs.py::test_everybody_hears_everybody",
    "register-accurate SJA1000": "chips/sja1000/test_registers.py::test_vectors_without_other_nodes",
    "and MCP2515 controllers": "chips/mcp2515/test_registers.py::test_reset_values_and_writable_bits",
    "`canwire share /dev/ttyUSB0`": "commands/test_share.py::test_adapters_come_to_a_running_hub",
    '`hub.bus("can0").faults`': "hub/faults/test_programs.py::test_vci_error_message_passive_and_bus_off",
    "`canwire fault`": "commands/test_fault.py::test_what_stays_is_listed_and_cleared",
    "`canwire_hub`": "test_pytest_hub.py::test_six_lines_for_a_program_and_an_error_frame",
    "**Another machine**": "hub/links/network/test_programs.py::test_what_is_recorded_here_is_seen_elsewhere_live",
    "`canwire serve --socketcand`": "socketcan/daemon/test_daemon.py::test_python_can_s_client",
    "**One virtual time**": "hub/test_lockstep.py::test_turns_go_by_name_at_each_instant",
    "**Thousands of runs**": "campaigns/test_running.py::test_workers_change_nothing_and_a_number_is_enough_to_repeat",
    "**ECUs to talk to**: UDS": "ecus/test_uds.py::test_identifiers",
    "udsoncan, canopen and": "ecus/test_canopen.py::test_it_boots_and_beats",
    "can-j1939": "ecus/test_j1939.py::test_an_address_is_claimed",
    "`canwire serve`, `devices`": "commands/test_devices.py::test_the_tree_tells_everything_that_changes",
    "`canwire dump`, `view`, `load`": "commands/view/test_screen.py::test_rows_come_and_change",
    "`canwire send`, `gen`, `simulate`": "commands/databases/test_by_name.py::test_a_node_is_simulated",
    "`canwire record`, `convert`, `play`": "commands/logs/test_verbs.py::test_convert",
    "`canwire stats`, `plot`, `query`": "commands/stats/test_stats.py::test_what_people_read",
    "signals as a picture or a page": "commands/plot/test_plot.py::test_the_samples_are_those_of_the_log",
    "SQL over traces of any size": "commands/query/test_verb.py::test_forms",
    "`canwire up`, `stop`, `detect`, `recover`": "commands/test_up.py::test_another_rate_sets_it_up_anew",
    "finds its bit rate": "commands/live/test_detect.py::test_the_verb",
    "gets it back from bus-off": "commands/test_recover.py::test_a_line_begins_again_whoever_holds_its_control",
    "`canwire bridge can0 can1`": "gateway/test_gateway.py::test_both_ways_by_the_rules",
    "`canwire isotp`, `uds`": "commands/transport/test_transport.py::test_services_by_name",
    "`canwire lin dump`, `send`, `schedule`": "commands/lin/test_verb.py::test_a_schedule_runs_while_the_command_does",
    "CANTERM, WCT, CANSPY": "commands/acan/test_term.py::test_what_is_typed_here_appears_there",
    "F&S's CanTestSuite": "commands/candrv/test_verb.py::test_can_send",
    "a frame bit by bit, bit timings": "commands/test_bits.py::test_page_for_people",
    "`timing`, `registers`": "commands/test_timing.py::test_from_a_bit_rate",
    "the registers of a board's chip": "commands/test_registers.py::test_of_a_board",
    "`canwire doctor`": "commands/doctor/test_doctor.py::test_it_looks_at_this_machine",
    "`canwire help VERB`": "commands/test_usage.py::test_help_has_the_usage_and_examples",
}


def smoke_tests() -> set[str]:
    """Tests that carry the marker."""
    found = set()
    for path in (ROOT / "tests").rglob("test_*.py"):
        text = path.read_text("utf-8")
        if "mark.smoke" not in text or path.name == Path(__file__).name:
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and any(
                ast.unparse(decorator) == "pytest.mark.smoke" for decorator in node.decorator_list
            ):
                found.add(f"{path.relative_to(ROOT / 'tests').as_posix()}::{node.name}")
    return found


def test_every_promise_has_a_test_and_every_smoke_test_a_promise() -> None:
    assert smoke_tests() == set(PROMISES.values())


@pytest.mark.parametrize("words", PROMISES)
def test_readme_makes_the_promise(words: str) -> None:
    readme = re.sub(r"\s+", " ", (ROOT / "README.md").read_text("utf-8"))
    assert words in readme
