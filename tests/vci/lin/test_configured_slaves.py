"""A VCI program as LIN master, and slaves of a served lab that answer node configuration as bought ones do."""

from __future__ import annotations

import time
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import Lab, LinNodeAttributes, LinProduct, vci
from tests.hubs import LONG_S
from tests.vci.programs import Program

pytestmark = pytest.mark.conforms("N-47")


def exchange(control: Any, port: Any, request: bytes) -> bytes:
    """A master request, and the first slave response to it; the slave is asked until it is ready."""
    put(control, vci.LinMsg(pid=0x3C, data=request))
    deadline = time.monotonic() + LONG_S
    while time.monotonic() < deadline:
        put(control, vci.LinMsg(pid=0x3D, ido=1, dlen=8))
        message = port.messages(1, vci.LIN_MSGTYPE_DATA, vci.LIN_MSGTYPE_ERROR)[0]
        if message.msg_info.type == vci.LIN_MSGTYPE_DATA and message.msg_info.pid & 0x3F == 0x3C:
            message = port.messages(1, vci.LIN_MSGTYPE_DATA, vci.LIN_MSGTYPE_ERROR)[0]
        if message.msg_info.type == vci.LIN_MSGTYPE_DATA:
            return bytes(message.data)
    raise AssertionError("no response")


def put(control: Any, message: vci.LinMsg) -> None:
    """On the bus, as soon as what was there before is over."""
    deadline = time.monotonic() + LONG_S
    while True:
        try:
            control.write_message(True, message)
            return
        except vci.VciError as error:
            if error.code != vci.VCI_E_BUSY or time.monotonic() > deadline:
                raise


def test_a_master_identifies_and_configures_a_slave(tmp_path: Path) -> None:
    attributes = LinNodeAttributes(LinProduct(0x1234, 0x5678, 1), nad=0x11, frames={0: 0x20})
    with Lab(time="real") as lab:
        slave = lab.lin_bus("lin0", bit_rate=19_200).slave(responses={0x20: b"\x07"}, attributes=attributes)
        address = lab.serve(str(tmp_path / "lab.sock"), boards=("usb-to-can-fd",))
        with canwire.connect(address) as hub, closing(Program(hub)) as program:
            board = hub.boards()[0].hardware_id
            port = program.monitor(board)
            control = program.lin(board, op_mode=vci.LIN_OPMODE_MASTER | vci.LIN_OPMODE_ERRORS)
            assert exchange(control, port, bytes.fromhex("1106B200FF7FFFFF")).hex() == "1106f23412785601"
            assert exchange(control, port, bytes.fromhex("1106B03412785601")).hex() == "1101f0ffffffffff"
            assert exchange(control, port, bytes.fromhex("0106B70047FFFFFF")).hex() == "0101f7ffffffffff"
            put(control, vci.LinMsg(pid=0x07, ido=1, dlen=1, ecs=1))
            message = port.message(vci.LIN_MSGTYPE_DATA)
            assert (message.msg_info.pid & 0x3F, message.data) == (0x07, b"\x07")
        assert slave.configuration is not None
        assert (slave.configuration.nad, slave.configuration.identifiers) == (0x01, {0: 0x07})


def test_a_slave_on_a_line_of_a_plain_hub_is_configured_too(
    hub: canwire.Hub, program: Program, lin_board: str
) -> None:
    with hub.open_lin_control(hub.board(lin_board).id, 2) as slave:
        slave.initialise(canwire.LinMode(master=False, bit_rate=19_200))
        slave.respond(canwire.LinFrame(0x20, b"\x07"))
        slave.configure(LinNodeAttributes(LinProduct(0x1234, 0x5678, 1), nad=0x11, frames={0: 0x20}))
        slave.start()
        port = program.monitor("HW000001")
        control = program.lin("HW000001", op_mode=vci.LIN_OPMODE_MASTER | vci.LIN_OPMODE_ERRORS)
        assert exchange(control, port, bytes.fromhex("1106B200FF7FFFFF")).hex() == "1106f23412785601"
        assert exchange(control, port, bytes.fromhex("1106B70047FFFFFF")).hex() == "1101f7ffffffffff"
        put(control, vci.LinMsg(pid=0x07, ido=1, dlen=1, ecs=1))
        message = port.message(vci.LIN_MSGTYPE_DATA)
        assert (message.msg_info.pid & 0x3F, message.data) == (0x07, b"\x07")
        assert slave.configuration().frames == {0: 0x07}
