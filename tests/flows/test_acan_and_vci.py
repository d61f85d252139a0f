"""One program on ACAN, one on VCI, one hub: three processes, and frames in both directions on one bus."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests import warm

LONG = 30  # seconds after which something that should happen never will
CONFIG = """
[[bus]]
name = "can0"

[[board]]
kind = "inducan104"
serial = "HW000104"
base = 0x280
irq = 5

[[board]]
kind = "usb-to-can-fd"
serial = "HW000001"
buses = ["can0", "can0", ""]
"""

ACAN = """
from canwire import Frame, acan

with acan.open() as driver:
    driver.configure(acan.HardConfig(rate_kbps=500, ts1=6, ts2=2, sjw=1))
    driver.bus_on()
    with driver.register(acan.TaskBlock([acan.Filter.any()], size=4096)) as block:
        print("ready", flush=True)
        input()
        for number in range(50):
            driver.send(Frame(0x100, bytes([number]) * 8), timeout=30)
        driver.send(Frame(0x18DA0001, b"acan", extended=True), timeout=30)
        for frame in block:
            print(f"{frame.id:x} {frame.data.hex()}", flush=True)
            if frame.data == b"bye":
                break
        input()
"""

VCI = """
from canwire import Event, vci

vci.initialize()
bal = vci.query_device_by_hwid("HW000001").open_component(vci.CLSID_VCIBAL, vci.IID_IBalObject)
control = bal.open_socket(0, vci.IID_ICanControl)
both = vci.CAN_OPMODE_STANDARD | vci.CAN_OPMODE_EXTENDED
control.init_line(vci.CanInitLine(op_mode=both, bt_reg0=vci.CAN_BT0_500KB, bt_reg1=vci.CAN_BT1_500KB))
channel = bal.open_socket(0, vci.IID_ICanSocket).create_channel(False)
channel.initialize(1000, 1000)
channel.activate()
reader, writer, event = channel.get_reader(), channel.get_writer(), Event()
reader.assign_event(event)
reader.set_threshold(1)
control.start_line()
print("ready", flush=True)
input()
for number in range(50):
    writer.put_data_entry(vci.CanMsg(msg_id=0x200, data=bytes([number, 255])))
writer.put_data_entry(vci.CanMsg(msg_id=0x18DA0002, data=b"vci", ext=1))
writer.put_data_entry(vci.CanMsg(msg_id=0x7FF, data=b"bye"))
done = False
while not done and event.wait(30):
    while reader.get_fill_count():
        message = reader.get_data_entry()
        if message.msg_info.type == vci.CAN_MSGTYPE_DATA:
            print(f"{message.msg_id:x} {message.data.hex()}", flush=True)
            done = message.data == b"acan"
input()
"""

Start = Callable[[str], "subprocess.Popen[str]"]


@pytest.fixture(params=["real", "fast"])
def start(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Start]:
    """Runs programs on a hub of their own; each says "ready" first, and goes on when it is told to."""
    address = str(tmp_path / "hub.sock")
    (tmp_path / "canwire.toml").write_text(CONFIG)
    monkeypatch.setenv("CANWIRE_HUB", address)
    running: list[subprocess.Popen[str]] = []

    def run(*command: str, first: str) -> subprocess.Popen[str]:
        process = warm.Popen([*command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        running.append(process)
        assert process.stdout is not None
        assert first in process.stdout.readline()
        return process

    serve = ["-m", "canwire", "serve", "--socket", address, "--config", str(tmp_path / "canwire.toml")]
    run(sys.executable, *serve, "--time", request.param, first="canwire hub on")
    yield lambda program: run(sys.executable, "-c", program, first="ready")
    for process in reversed(running):
        process.kill()
        process.communicate()


def tell(process: subprocess.Popen[str]) -> None:
    assert process.stdin is not None
    process.stdin.write("\n")
    process.stdin.flush()


def lines(process: subprocess.Popen[str], count: int) -> list[str]:
    assert process.stdout is not None
    return [process.stdout.readline().strip() for _ in range(count)]


@pytest.mark.conforms("AC-21", "AC-31", "X3-19")
def test_an_acan_and_a_vci_program_exchange_frames(start: Start) -> None:
    on_acan, on_vci = start(ACAN), start(VCI)
    for process in (on_acan, on_vci):
        tell(process)
    numbers = range(50)
    from_vci = [f"200 {number:02x}ff" for number in numbers] + [
        f"18da0002 {b'vci'.hex()}",
        f"7ff {b'bye'.hex()}",
    ]
    from_acan = [f"100 {bytes([number] * 8).hex()}" for number in numbers] + [f"18da0001 {b'acan'.hex()}"]
    assert lines(on_acan, len(from_vci)) == from_vci
    assert lines(on_vci, len(from_acan)) == from_acan
    for process in (on_acan, on_vci):
        process.communicate("\n", LONG)
        assert process.returncode == 0


def test_each_goes_on_when_the_other_dies(start: Start) -> None:
    """The ACAN line stays on the bus after its program: it acknowledges what the VCI program sends."""
    on_acan, on_vci = start(ACAN), start(VCI)
    on_acan.kill()
    on_acan.communicate()
    tell(on_vci)
    again = start(ACAN)
    tell(again)
    assert lines(on_vci, 51)[-1] == f"18da0001 {b'acan'.hex()}"
    on_vci.communicate("\n", LONG)
    assert on_vci.returncode == 0
