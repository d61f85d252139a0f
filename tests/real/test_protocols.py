"""canopen, can-isotp, udsoncan and can-j1939 over `interface="canwire"`; skipped where they are missing."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Iterator

import can
import pytest

LONG = 30
pytestmark = [pytest.mark.usefixtures("hub"), pytest.mark.filterwarnings("default::DeprecationWarning")]


def open_bus(**more: object) -> can.BusABC:
    return can.Bus(interface="canwire", channel="can0", bitrate=500_000, **more)


def test_canopen(hub: str) -> None:
    canopen = pytest.importorskip("canopen", reason="canopen is not installed")
    dictionary = canopen.ObjectDictionary()
    for index, kind in (
        (0x2000, canopen.objectdictionary.UNSIGNED32),
        (0x2001, canopen.objectdictionary.DOMAIN),
    ):
        variable = canopen.objectdictionary.ODVariable(f"variable {index:x}", index, 0)
        variable.data_type, variable.access_type = kind, "rw"
        dictionary.add_object(variable)
    device, master = canopen.Network(), canopen.Network()
    device.connect(interface="canwire", channel="can0", bitrate=500_000)
    master.connect(interface="canwire", channel="can0", bitrate=500_000)
    try:
        local = device.create_node(5, dictionary)
        remote = master.add_node(5, dictionary)
        remote.sdo.RESPONSE_TIMEOUT = LONG
        remote.sdo[0x2000].raw = 0xDEADBEEF  # expedited
        assert local.sdo[0x2000].raw == remote.sdo[0x2000].raw == 0xDEADBEEF
        long = bytes(range(256)) * 4  # segmented
        remote.sdo.download(0x2001, 0, long)
        assert remote.sdo.upload(0x2001, 0) == long
        remote.nmt.state = "OPERATIONAL"
        deadline = time.monotonic() + LONG
        while local.nmt.state != "OPERATIONAL" and time.monotonic() < deadline:
            time.sleep(0.01)
        assert local.nmt.state == "OPERATIONAL"
    finally:
        master.disconnect()
        device.disconnect()


class Stacks:
    """Two ISO-TP stacks that talk to each other."""

    def __init__(self, isotp: object, *, fd: bool) -> None:
        more = {"tx_data_length": 64, "can_fd": True, "bitrate_switch": True} if fd else {}
        self.buses = [open_bus(fd=fd), open_bus(fd=fd)]
        self.stacks = []
        for bus, (tx, rx) in zip(self.buses, ((0x7E0, 0x7E8), (0x7E8, 0x7E0)), strict=True):
            address = isotp.Address(isotp.AddressingMode.Normal_11bits, txid=tx, rxid=rx)
            self.stacks.append(isotp.CanStack(bus, address=address, params={"stmin": 0, **more}))

    def __enter__(self) -> list[object]:
        for stack in self.stacks:
            stack.start()
        return self.stacks

    def __exit__(self, *_: object) -> None:
        for stack in self.stacks:
            stack.stop()
        for bus in self.buses:
            bus.shutdown()


@pytest.mark.parametrize("fd", [False, True])
def test_isotp(hub: str, fd: bool) -> None:
    isotp = pytest.importorskip("isotp", reason="can-isotp is not installed")
    with Stacks(isotp, fd=fd) as (one, other):
        for size in (1, 7, 8, 62, 63, 500, 4095):
            sent = bytes(k * 7 & 0xFF for k in range(size))
            one.send(sent)
            assert other.recv(block=True, timeout=LONG) == sent
            other.send(sent[::-1])
            assert one.recv(block=True, timeout=LONG) == sent[::-1]


def test_uds(hub: str) -> None:
    isotp = pytest.importorskip("isotp", reason="can-isotp is not installed")
    udsoncan = pytest.importorskip("udsoncan", reason="udsoncan is not installed")
    from udsoncan.client import Client
    from udsoncan.connections import PythonIsoTpConnection

    client_bus, server_bus = open_bus(), open_bus()
    normal = isotp.AddressingMode.Normal_11bits
    client_stack = isotp.CanStack(client_bus, address=isotp.Address(normal, txid=0x7E0, rxid=0x7E8))
    server = isotp.CanStack(server_bus, address=isotp.Address(normal, txid=0x7E8, rxid=0x7E0))
    server.start()

    def serve() -> None:
        while (request := server.recv(block=True, timeout=LONG)) not in (None, b"\x11\x01"):
            server.send(
                bytes([request[0] + 0x40]) + request[1:3] + (b"canwire" if request[0] == 0x22 else b"")
            )
        server.send(b"\x51\x01")

    thread = threading.Thread(target=serve)
    thread.start()
    config = {**udsoncan.configs.default_client_config, "request_timeout": LONG, "p2_timeout": LONG}
    config["data_identifiers"] = {0xF190: udsoncan.AsciiCodec(7)}
    with Client(PythonIsoTpConnection(client_stack), config=config) as client:
        assert client.read_data_by_identifier(0xF190).service_data.values[0xF190] == "canwire"
        assert client.tester_present().positive
        assert client.ecu_reset(udsoncan.services.ECUReset.ResetType.hardReset).positive
    thread.join(LONG)
    server.stop()
    client_bus.shutdown()
    server_bus.shutdown()


@pytest.fixture
def ecus(hub: str) -> Iterator[list[object]]:
    j1939 = pytest.importorskip("j1939", reason="can-j1939 is not installed")
    made = []
    for _ in range(2):
        ecu = j1939.ElectronicControlUnit()
        ecu.connect(interface="canwire", channel="can0", bitrate=250_000)
        made.append(ecu)
    yield made
    for ecu in made:
        ecu.disconnect()


def test_j1939(ecus: list[object]) -> None:
    """Address claims, and messages of one frame, by BAM, and by RTS and CTS."""
    import j1939

    heard: queue.Queue[tuple[int, bytes]] = queue.Queue()
    applications = []
    for number, ecu in enumerate(ecus):
        name = j1939.Name(identity_number=number + 1, function=1, arbitrary_address_capable=0)
        application = j1939.ControllerApplication(name, 0x80 + number)
        ecu.add_ca(controller_application=application)
        application.start()
        applications.append(application)
    applications[1].subscribe(lambda priority, pgn, source, stamp, data: heard.put((pgn, bytes(data))))
    deadline = time.monotonic() + LONG
    normal = j1939.ControllerApplication.State.NORMAL
    while any(one.state != normal for one in applications) and time.monotonic() < deadline:
        time.sleep(0.01)
    for destination, length in ((0x81, 8), (0x81, 500), (0xFF, 100)):
        sent = [k & 0xFF for k in range(length)]
        assert applications[0].send_pgn(0, 0xEF, destination, 6, sent)
        pgn, data = heard.get(timeout=LONG)
        assert (pgn & 0x3FF00, data) == (
            0xEF00,
            bytes(sent),
        )  # a broadcast's has its destination in the low byte
