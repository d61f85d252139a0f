"""`ip link` and whatever else speaks rtnetlink: the interfaces shown, set up, taken down."""

from __future__ import annotations

import json
import sys
from typing import Any

import pytest

import canwire
from canwire.socketcan.netlink import messages as m
from tests.hubs import LONG_S
from tests.missing import find_program
from tests.socketcan.bench import Bench, finished


def shown(bench: Bench, *words: str) -> dict[str, Any]:
    """`ip -json -details -statistics link show` of can0, after `ip link` with these words."""
    find_program("ip")
    commands = [f"ip link set can0 {word}" for word in words]
    commands.append("ip -json -details -statistics link show can0")
    (found,) = json.loads(bench.run("sh", "-ec", "; ".join(commands)))
    assert isinstance(found, dict)
    return found


def refused(bench: Bench, what: str, *, before: str = "true") -> str:
    """What `ip link set can0` says to this."""
    find_program("ip")
    process = bench.start("sh", "-c", f"{before}; exec ip link set can0 {what}")
    _, errors = process.communicate(timeout=LONG_S)
    assert process.returncode == 2
    return errors.strip()


@pytest.mark.conforms("N-50")
@pytest.mark.finding("socketcan 5")
def test_what_is_shown(bench: Bench) -> None:
    link = shown(bench)
    assert {"NOARP", "UP", "LOWER_UP", "ECHO"} == set(link["flags"])
    assert (link["ifindex"], link["operstate"], link["link_type"], link["txqlen"]) == (
        1001,
        "UP",
        "can",
        1000,
    )
    data = link["linkinfo"]["info_data"]
    assert (data["state"], data["berr_counter"]) == ("ERROR-ACTIVE", {"tx": 0, "rx": 0})
    assert data["bittiming"]["bitrate"] == 500_000
    assert set(link["stats64"]["rx"].values()) == {0}


def test_all_are_beside_the_kernel_s(bench: Bench) -> None:
    find_program("ip")
    names = {link["ifname"] for link in json.loads(bench.run("ip", "-json", "link"))}
    assert {"can0", "HW000001_0", "lo"} <= names
    assert "127.0.0.1" in bench.run("ip", "addr", "show", "lo")


@pytest.mark.conforms("N-50")
def test_a_line_is_set_up_and_started_for_good(bench: Bench) -> None:
    data = shown(bench, "up type can bitrate 250000 sample-point 0.8")["linkinfo"]["info_data"]
    assert (data["bittiming"]["bitrate"], data["bittiming"]["sample_point"]) == (250_000, "0.800")
    running = [place.status(bench.hub) for place in canwire.every_line(bench.hub, "CAN")]
    (status,) = [status for status in running if status.running]
    assert status.mode is not None
    assert status.mode.persistent
    assert shown(bench)["linkinfo"]["info_data"]["bittiming"]["bitrate"] == 250_000
    assert shown(bench, "down")["operstate"] == "DOWN"
    assert not any(place.status(bench.hub).running for place in canwire.every_line(bench.hub, "CAN"))


@pytest.mark.conforms("N-50")
def test_statistics_are_the_line_s(bench: Bench) -> None:
    program = """
import json, socket, subprocess
wire = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
wire.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_RECV_OWN_MSGS, 1)
wire.bind(("can0",))
for _ in range(3):
    wire.send(bytes(16))
    wire.recv(16)
(link,) = json.loads(subprocess.check_output(["ip", "-json", "-s", "link", "show", "can0"]))
assert link["stats64"]["tx"]["packets"] == 3, link
"""
    find_program("ip")
    bench.run(sys.executable, "-c", program)


@pytest.mark.conforms("N-50")
def test_a_program_on_it_notices(bench: Bench) -> None:
    """Its read fails once the interface goes down, and it hears again once that is up, at the new rate."""
    program = """
import errno, socket, subprocess
wire = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
wire.bind(("can0",))
wire.settimeout(10)
def ip(*words):
    subprocess.run(["ip", "link", "set", "can0", *words], check=True)
ip("down")
try:
    wire.recv(16)
except OSError as error:
    assert error.errno == errno.ENETDOWN, error
ip("type", "can", "bitrate", "125000")
ip("up")
other = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
other.bind(("can0",))
other.send(bytes([0x23, 1, 0, 0, 1]) + bytes(3) + b"1" + bytes(7))
assert wire.recv(16)[8:9] == b"1"
"""
    find_program("ip")
    bench.run(sys.executable, "-c", program)


DOWN_BEFORE = """
import errno, socket, subprocess
def ip(what):
    subprocess.run(["ip", "link", "set", "can0", what], check=True)
def bound(kind, type, protocol, *name):
    made = socket.socket(kind, type, protocol)
    made.bind(("can0", *name))
    made.settimeout(10)
    return made
ip("down")
both = bound(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW), bound(socket.AF_PACKET, socket.SOCK_RAW, 0, 0xC)
for one in both:
    for call in (lambda: one.recv(16), lambda: one.send(bytes(16))):
        try:
            call()
        except OSError as error:
            assert error.errno == errno.ENETDOWN, error
        else:
            raise AssertionError(one)
ip("up")
both[0].send(bytes(16))
assert both[1].recv(16) == bytes(16)
both[1].send(bytes(16))
assert both[0].recv(16) == bytes(16)
"""


@pytest.mark.conforms("N-50")
def test_who_binds_to_an_interface_that_is_down_hears_it_once_it_is_up(bench: Bench) -> None:
    find_program("ip")
    bench.run(sys.executable, "-c", DOWN_BEFORE)


NOT_SET = {
    "type can bitrate 123456789": "Invalid argument",
    "type can restart": "can0 is down, or no program here uses it",
    "type can one-shot on": "Operation not supported",
    "mtu 1500": "can0: its MTU is its line's",
    "name other": "canwire run --interface NAME=LINE gives other names",
}


FILES = """
import os
below = "/sys/class/net"
names = os.listdir(below)
assert {"can0", "HW000001_0", "lo"} <= set(names), names
def said(path):
    with open(f"{below}/{path}") as file:
        return file.read()
assert said("can0/type") == "280\\n"
assert said("lo/type") == "772\\n"
assert (said("can0/flags"), said("can0/operstate"), said("can0/ifindex")) == ("0x400c1\\n", "up\\n", "1001\\n")
assert said("can0/statistics/tx_packets") == "0\\n"
assert os.path.isdir(f"{below}/can0/statistics") and os.access(f"{below}/can0/mtu", os.R_OK)
assert not os.path.exists(f"{below}/can7") and not os.path.exists(f"{below}er")
os.system("cansend can0 123#11; ip link set can0 down")
assert (said("can0/operstate"), said("can0/statistics/tx_packets")) == ("down\\n", "1\\n")
"""


@pytest.mark.conforms("N-50")
def test_files_of_sysfs(bench: Bench) -> None:
    find_program("cansend")
    find_program("ip")
    bench.run(sys.executable, "-c", FILES)


IN_PROC = """
import os, socket, struct
wire = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
wire.bind(("can0",))
full = 0xC0000000
filters = struct.pack("<8I", 0x123, full | 0x7FF, 0x80000456, full | 0x1FFFFFFF, 0x20000007, 0x7FF, 0x100, 0x700)
wire.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, filters)
wire.setsockopt(socket.SOL_CAN_RAW, 2, 0xFF)
def said(name):
    with open(f"/proc/net/{name}") as file:
        return file.read()
none = "0" * 16
for name, where in (
    ("sff", "123       c00007ff"), ("eff", "80000456  dfffffff"), ("inv", "20000007  000007ff"),
    ("fil", "100       00000700"), ("err", "000       200000ff"),
):
    text = said("can/rcvlist_" + name)
    assert text.startswith(f"\\nreceive list 'rx_{name}':\\n  (any: no entry)\\n  device   can_id"), text
    assert f"   can0   {where}  {none}  {none}         0  raw\\n" in text, text
assert "  (can0: no entry)\\n" in said("can/rcvlist_all")
assert "        5 current receive list entries (CRCV)\\n" in said("can/stats")
assert said("can/version") == "rev 20170425 abi 9\\n"
assert "\\n  can0:" in said("dev") and "\\n    lo:" in said("dev")
assert os.access("/proc/net/can/rcvlist_all", os.R_OK) and not os.path.exists("/proc/net/can/nothing")
assert sorted(os.listdir("/proc/self/net/can"))[0] == "rcvlist_all"
"""


@pytest.mark.conforms("N-50")
def test_files_of_proc(bench: Bench) -> None:
    bench.run(sys.executable, "-c", IN_PROC)


NOTIFIED = """
import socket, struct, subprocess
by_mask = socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, 0)
by_mask.bind((0, 1))
by_option = socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, 0)
by_option.setsockopt(270, 1, 1)
by_option.bind((0, 0))
subprocess.run(["ip", "link", "set", "can0", "up"], check=True)
subprocess.run(["ip", "link", "set", "can0", "down"], check=True)
for one in (by_mask, by_option):
    one.settimeout(10)
    flags = 1
    while flags & 1:
        data, (port, _) = one.recvfrom(1 << 16)
        kind, index, flags = struct.unpack_from("<4xH10x4xiI", data)
        assert (kind, index, port) == (16, 1001, 0), (kind, index, port)
by_option.setsockopt(270, 2, 1)
subprocess.run(["ip", "link", "set", "can0", "up"], check=True)
by_mask.recv(1 << 16)
by_option.setblocking(False)
try:
    while True:
        assert not struct.unpack_from("<20xiI", by_option.recv(1 << 16))[1] & 1
except BlockingIOError:
    pass
"""


@pytest.mark.conforms("N-50")
def test_changes_are_told(bench: Bench) -> None:
    find_program("ip")
    bench.run(sys.executable, "-c", NOTIFIED)


COME_AND_GO = """
import socket, struct
told = socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, 0)
told.bind((0, 1))
print("listening", flush=True)
def hears(what):
    while True:
        data = told.recv(1 << 16)
        if struct.unpack_from("<4xH", data)[0] == what and b"HW000077_0" in data:
            return
hears(16)
print("came", flush=True)
hears(17)
"""


def test_boards_that_come_and_go_are_told(bench: Bench) -> None:
    program = bench.start(sys.executable, "-c", COME_AND_GO)
    assert program.stdout is not None
    assert program.stdout.readline() == "listening\n"
    bench.hub.plug("usb-to-can-fd", "HW000077", buses=("can0", "can0"))
    assert program.stdout.readline() == "came\n"
    bench.hub.unplug("HW000077")
    finished(program)


RESTARTED = """
import socket, struct, subprocess
wire = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
wire.setsockopt(socket.SOL_CAN_RAW, 2, 0x1FFFFFFF)
subprocess.run(["ip", "link", "set", "can0", "type", "can", "restart-ms", "{restart_ms}"], check=True)
wire.bind(("can0",))
wire.settimeout(20)
wire.send(struct.pack("=IB3x", 0x123, 0) + bytes(8))
def until(kind):
    while struct.unpack_from("=I", wire.recv(16))[0] & (0x20000000 | kind) != 0x20000000 | kind:
        pass
until(0x40)
if not {restart_ms}:
    subprocess.run(["ip", "link", "set", "can0", "type", "can", "restart"], check=True)
until(0x100)
wire.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_RECV_OWN_MSGS, 1)
wire.send(struct.pack("=IB3x", 0x124, 0) + bytes(8))
while struct.unpack_from("=I", wire.recv(16))[0] != 0x124:
    pass
subprocess.run(["ip", "link", "set", "can0", "type", "can", "restart"], check=False)
"""


@pytest.mark.conforms("N-50")
@pytest.mark.finding("socketcan 16")
@pytest.mark.parametrize("restart_ms", [0, 5], ids=["by hand", "by itself"])
def test_an_interface_leaves_bus_off(bench: Bench, restart_ms: int) -> None:
    find_program("ip")
    with bench.hub.bus("can0").faults.flip(frame_id=0x123, bit="crc delimiter", times=32, seen_by="sender"):
        program = bench.start(sys.executable, "-c", RESTARTED.format(restart_ms=restart_ms))
        _, errors = program.communicate(timeout=LONG_S)
    assert program.returncode == 0, errors
    assert "can0 is not in bus-off" in errors


def test_what_cannot_be_set(bench: Bench) -> None:
    find_program("ip")
    script = "".join(f"ip link set can0 {what}; echo $? >&2; " for what in NOT_SET)
    _, errors = bench.start("sh", "-c", script).communicate(timeout=LONG_S)
    said = errors.splitlines()
    assert said[1::2] == ["2"] * len(NOT_SET)
    assert all(why in line for why, line in zip(NOT_SET.values(), said[::2], strict=True)), errors


def test_a_line_that_runs_is_not_set_up_otherwise(bench: Bench) -> None:
    find_program("candump")
    said = refused(bench, "type can bitrate 125000", before="candump can0 -n 1 -T 3000 & sleep 0.5")
    assert "can0: the line runs; take it down before it is set up otherwise" in said


def test_a_bus_that_runs_at_another_rate(bench: Bench) -> None:
    shown(bench, "up type can bitrate 250000")
    assert "HW000001:0 runs at 250000 bit/s" in refused(bench, "up type can bitrate 125000")


def test_whoever_else_sends_to_the_server_is_not_heard() -> None:
    """Messages that are cut short, lengths that cannot be: nothing of them is taken, and nothing fails."""
    whole = m.message(m.GET_LINK, 0, 7, 0, bytes(16))
    assert [one.sequence for one in m.requests_in(whole + whole)] == [7, 7]
    assert list(m.requests_in(whole[:-1])) == []
    assert list(m.requests_in(b"\xff" * 64)) == []
    assert list(m.requests_in(bytes(64))) == []
    assert m.attributes_in(b"\0" * 12) == {}
    assert m.attributes_in(m.attribute(3, b"can0\0") + b"\x0c") == {3: b"can0\0"}
    error = next(m.requests_in(m.answer_to(next(m.requests_in(whole)), 9, 19, "why")))
    assert (error.kind, error.flags, error.body[:4]) == (m.ERROR, m.WITH_ATTRIBUTES, b"\xed\xff\xff\xff")
