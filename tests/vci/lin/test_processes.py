"""Programs that share a board: a LIN line and two CAN lines."""

from __future__ import annotations

import subprocess
import sys

import pytest

LINE = 2  # the LIN line
LONG = 30

_PROGRAM = """
import contextlib
import sys
import canwire
from canwire import vci

address, kind, line = sys.argv[1], sys.argv[2], int(sys.argv[3])
vci.initialize(address)


def received(reader, event):
    while True:
        try:
            message = reader.get_data_entry()
        except vci.VciRxQueueEmpty:
            assert event.wait(30)
            continue
        if message.msg_info.type == 0:
            return message


with (
    vci.query_device_by_hwid("HW000001") as device,
    device.open_component(vci.CLSID_VCIBAL, vci.IID_IBalObject) as bal,
    contextlib.closing(canwire.Event()) as event,
):
    if kind == "lin":
        with (
            bal.open_socket(line, vci.IID_ILinSocket) as socket,
            socket.create_monitor(False) as monitor,
            bal.open_socket(line, vci.IID_ILinControl) as control,
        ):
            monitor.initialize(100)
            monitor.activate()
            control.init_line(vci.LinInitLine(op_mode=vci.LIN_OPMODE_MASTER, bitrate=19200))
            control.start_line()
            with monitor.get_reader() as reader:
                reader.assign_event(event)
                print("ready", flush=True)
                input()
                control.write_message(True, vci.LinMsg(pid=5, data=b"lin", ecs=1))
                print(received(reader, event).data.decode(), flush=True)
                input()
    else:
        with (
            bal.open_socket(line, vci.IID_ICanSocket2) as socket,
            socket.create_channel(False) as channel,
            bal.open_socket(line, vci.IID_ICanControl2) as control,
        ):
            channel.initialize(100, 100)
            channel.activate()
            control.init_line(vci.CanInitLine2(op_mode=vci.CAN_OPMODE_STANDARD, btp_sdr=vci.CAN_BTP_500KB))
            control.start_line()
            with channel.get_reader() as reader, channel.get_writer() as writer:
                reader.assign_event(event)
                print("ready", flush=True)
                input()
                writer.put_data_entry(vci.CanMsg2(msg_id=line, data=b"can%d" % line))
                print(received(reader, event).data.decode(), flush=True)
                input()
"""


@pytest.mark.conforms("X4-49")
def test_three_programs_use_three_lines_of_one_board(hub_process: str, source_directory: str) -> None:
    command = [sys.executable, "-c", _PROGRAM, hub_process]
    programs = [
        subprocess.Popen(
            [*command, kind, str(line)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={"PYTHONPATH": source_directory},
        )
        for kind, line in (("can", 0), ("can", 1), ("lin", LINE))
    ]
    try:
        assert [said(one) for one in programs] == ["ready"] * 3
        for one in programs:
            tell(one)
        assert [said(one) for one in programs] == ["can1", "can0", "lin"]
        for one in programs:
            tell(one)
        assert [one.wait(LONG) for one in programs] == [0, 0, 0]
    finally:
        for one in programs:
            one.kill()
            one.communicate()


def said(program: subprocess.Popen[str]) -> str:
    assert program.stdout is not None
    return program.stdout.readline().strip()


def tell(program: subprocess.Popen[str]) -> None:
    assert program.stdin is not None
    program.stdin.write("\n")
    program.stdin.flush()
