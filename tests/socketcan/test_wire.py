"""Frames between the hub's records and the kernel's structures, and the table that the shim reads."""

from __future__ import annotations

import re
import struct
import subprocess
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from canwire import Frame, frames_to_array
from canwire.socketcan import table
from canwire.socketcan.constants import CAN_EFF_FLAG, CAN_ERR_FLAG, CAN_RTR_FLAG
from canwire.socketcan.table import Table
from canwire.socketcan.wire import frames_received, numpy_module, records_to_send, sent_dtype, sound
from tests.cases import each
from tests.missing import find_program

SHIM = Path(table.__file__).parent / "shim"


@st.composite
def any_frame(draw: st.DrawFn) -> Frame:
    extended = draw(st.booleans())
    id = draw(st.integers(0, 0x1FFFFFFF if extended else 0x7FF))
    kind = draw(st.sampled_from(["data", "remote", "fd"]))
    if kind == "remote":
        return Frame(id, extended=extended, remote=True, dlc=draw(st.integers(0, 8)))
    if kind == "data":
        data = draw(st.binary(max_size=8))
        dlc = draw(st.sampled_from([None, 9, 15])) if len(data) == 8 else None
        return Frame(id, data, extended=extended, dlc=dlc)
    size = draw(st.sampled_from([0, 1, 8, 12, 24, 64]))
    data = draw(st.binary(min_size=size, max_size=size))
    flags = draw(st.booleans()), draw(st.booleans())
    return Frame(
        id, data, extended=extended, fd=True, bit_rate_switch=flags[0], error_state_indicator=flags[1]
    )


@given(st.lists(any_frame(), min_size=1, max_size=5))
def test_what_is_received_can_be_sent_and_is_the_same_frame(frames: list[Frame]) -> None:
    records = frames_to_array(frames)
    rows = frames_received(records, 7, 0)
    sent = numpy_module().zeros(len(rows), sent_dtype())
    sent["interface"], sent["size"] = rows["interface"], rows["length"]
    for name in ("can_id", "len", "fd_flags", "raw_dlc", "data"):
        sent[name] = rows[name]
    assert sound(sent).all()
    again = records_to_send(sent)
    assert again.tobytes() == records.tobytes()


def test_the_kernel_s_form_of_a_frame() -> None:
    frame = Frame(0x12345678, b"\x01\x02", extended=True)
    (row,) = frames_received(frames_to_array([frame, Frame(0x7FF, remote=True, dlc=3)]), 5, 1000)[:1]
    assert (row["can_id"], row["len"], row["length"], row["interface"]) == (0x92345678, 2, 16, 5)
    remote = frames_received(frames_to_array([Frame(0x7FF, remote=True, dlc=3)]), 5, 0)[0]
    assert (remote["can_id"], remote["len"]) == (0x7FF | CAN_RTR_FLAG, 3)


@each(
    ("size", "length", "can_id"),
    [(16, 9, 1), (72, 65, 1), (0, 0, 1), (17, 0, 1), (16, 0, CAN_ERR_FLAG)],
)
def test_what_no_bus_could_carry_is_passed_over(size: int, length: int, can_id: int) -> None:
    row = numpy_module().zeros(1, sent_dtype())
    row["size"], row["len"], row["can_id"] = size, length, can_id
    assert not sound(row).any()


def test_an_identifier_beyond_its_format_is_cut_as_the_kernel_s_drivers_do() -> None:
    row = numpy_module().zeros(1, sent_dtype())
    row["size"], row["can_id"] = 16, 0x1FFFF123
    assert records_to_send(row)["id"][0] == 0x123
    row["can_id"] = 0x1FFFF123 | CAN_EFF_FLAG
    assert records_to_send(row)["id"][0] == 0x1FFFF123


LAYOUT = r"""
#include "ring.h"
#include <stdio.h>
#define SHOW(what) printf(#what " %zu\n", (size_t)(what))
int main(void)
{
    SHOW(sizeof(struct table)); SHOW(sizeof(struct slot)); SHOW(sizeof(struct interface));
    SHOW(offsetof(struct table, interface)); SHOW(offsetof(struct table, slot));
    SHOW(offsetof(struct table, interfaces));
    SHOW(offsetof(struct interface, flags)); SHOW(offsetof(struct slot, interface));
    SHOW(offsetof(struct slot, fd_frames));
    SHOW(offsetof(struct slot, receive_buffer)); SHOW(offsetof(struct slot, error));
    SHOW(offsetof(struct slot, receives)); SHOW(sizeof(struct received));
    SHOW(sizeof(struct sent)); SHOW(RECEIVED_SIZE); SHOW(SENT_SIZE); SHOW(MOST_SLOTS);
}
"""


def test_both_sides_have_the_same_layout(tmp_path: Path) -> None:
    find_program("gcc")
    (tmp_path / "layout.c").write_text(LAYOUT)
    command = ["gcc", "-std=gnu11", f"-I{SHIM}", str(tmp_path / "layout.c"), "-o", str(tmp_path / "layout")]
    subprocess.run(command, check=True)
    output = subprocess.run([tmp_path / "layout"], check=True, capture_output=True, text=True).stdout
    told = {name: int(value) for name, value in re.findall(r"^(.*) (\d+)$", output, re.M)}
    assert told == {
        "sizeof(struct table)": table._SIZE,
        "sizeof(struct slot)": table._SLOT.size,
        "sizeof(struct interface)": table._INTERFACE_SIZE,
        "offsetof(struct table, interface)": table._INTERFACES_AT,
        "offsetof(struct table, slot)": table._SLOTS_AT,
        "offsetof(struct table, interfaces)": table._COUNT_AT,
        "offsetof(struct interface, flags)": table._FLAGS_OFFSET,
        "offsetof(struct slot, interface)": table._BOUND_OFFSET,
        "offsetof(struct slot, fd_frames)": table._FD_OFFSET,
        "offsetof(struct slot, receive_buffer)": table._RECEIVE_OFFSET,
        "offsetof(struct slot, error)": table._ERROR_OFFSET,
        "offsetof(struct slot, receives)": table._IDENTIFIERS_OFFSET,
        "sizeof(struct received)": 24,
        "sizeof(struct sent)": 8,
        "RECEIVED_SIZE": 96,
        "SENT_SIZE": 80,
        "MOST_SLOTS": table.MOST_SLOTS,
    }


def test_all_slots_taken(tmp_path: Path) -> None:
    made = Table(str(tmp_path / "table"), b"prefix-")
    slots = [made.take_slot(1, 3) for _ in range(table.MOST_SLOTS)]
    assert sorted(slot for slot in slots if slot is not None) == list(range(table.MOST_SLOTS))
    assert made.take_slot(1, 3) is None
    made.free_slot(5)
    assert made.take_slot(1, 3) == 5
    assert struct.unpack_from("<Q", (tmp_path / "table").read_bytes())[0] == table.MAGIC
    made.close()
