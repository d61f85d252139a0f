"""canwire's small ECUs on shared boards, over `interface="canwire"`, beside the libraries' own clients."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from typing import Any

import pytest

LONG = 30
pytestmark = [
    pytest.mark.usefixtures("hub"),
    pytest.mark.realtime,
    pytest.mark.filterwarnings("default::DeprecationWarning"),
]


@pytest.fixture
def canopen_networks(hub: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Any]]:
    canopen = pytest.importorskip("canopen", reason="canopen is not installed")
    monkeypatch.setattr(canopen.Network, "NOTIFIER_CYCLE", 0.05)  # which `disconnect` waits for
    made = [canopen.Network() for _ in range(2)]
    for network in made:
        network.connect(interface="canwire", channel="can0", bitrate=500_000)
    yield made
    for network in made:
        network.disconnect()


@pytest.mark.conforms("PP-04")
def test_canopen(canopen_networks: list[Any]) -> None:
    """SDOs, heartbeats, PDOs both ways and on SYNC, an emergency, a reset."""
    from canwire.ecus import CanopenEcu

    device, master = canopen_networks
    ecu = CanopenEcu(5)
    remote = master.add_node(5, CanopenEcu.EDS)
    remote.sdo.RESPONSE_TIMEOUT = LONG
    booted, beaten, changed, sampled = (threading.Event() for _ in range(4))
    remote.nmt.add_heartbeat_callback(lambda state: booted.set() if state == 0 else beaten.set())
    device.create_node(ecu)
    assert booted.wait(LONG)
    assert remote.sdo["Device name"].raw == "canwire small I/O"
    program = bytes(range(256))
    remote.sdo.download(0x2001, 0, program)
    assert remote.sdo.upload(0x2001, 0) == program
    beaten.clear()
    remote.sdo[0x1017].raw = 20
    assert beaten.wait(LONG)
    remote.tpdo.read()
    remote.rpdo.read()
    remote.tpdo[1].add_callback(lambda pdo: changed.set() if pdo[0].raw == 0x5A else None)
    remote.tpdo[2].add_callback(lambda pdo: sampled.set() if pdo[0].raw == -5 else None)
    remote.nmt.state = "OPERATIONAL"
    written = threading.Event()
    ecu.add_write_callback(lambda index, subindex, od, data: written.set() if index == 0x6200 else None)
    remote.rpdo[1][0].raw = 0xA5
    remote.rpdo[1].transmit()  # behind the start: the ECU is operational when it has come
    assert written.wait(LONG)
    ecu.sdo["Inputs"][1].raw = 0x5A
    assert changed.wait(LONG)
    ecu.sdo["Analogue inputs"][1].raw = -5
    master.sync.transmit()
    assert sampled.wait(LONG)
    assert remote.sdo["Outputs"][1].raw == 0xA5
    told: queue.Queue[Any] = queue.Queue()
    remote.emcy.add_callback(told.put)
    ecu.emcy.send(0x4210, 8)
    assert told.get(timeout=LONG).code == 0x4210
    booted.clear()
    remote.nmt.state = "RESET"
    assert booted.wait(LONG)
    assert remote.sdo["Outputs"][1].raw == 0


@pytest.mark.conforms("PP-03")
def test_j1939(hub: str) -> None:
    """A contest for an address, a request answered by BAM, RTS and CTS both ways."""
    j1939 = pytest.importorskip("j1939", reason="can-j1939 is not installed")
    from canwire.ecus import J1939Ecu

    vin, long = b"CANWIRE0123456789*", bytes(range(100))
    heard: list[queue.Queue[tuple[int, int, bytes]]] = [queue.Queue() for _ in range(2)]

    def ecu(number: int, **more: Any) -> Any:
        name = j1939.Name(identity_number=number, arbitrary_address_capable=1)
        return J1939Ecu(0x80, name=name, on_message=lambda *words: heard[number].put(words), **more)

    units, ecus = [], [ecu(0), ecu(1, groups={0xFEEC: vin})]
    for each in ecus:
        unit = j1939.ElectronicControlUnit()
        unit.connect(interface="canwire", channel="can0", bitrate=250_000)
        units.append(unit)
        each.start(unit)
    claimed = threading.Event()

    def look(_: Any) -> bool:
        if [each.address for each in ecus] == [0x80, 0x81]:
            claimed.set()
        return True

    units[0].add_timer(0.02, look)
    try:
        assert claimed.wait(LONG)
        ecus[0].application.send_request(0, 0xFEEC, 0x81)
        assert heard[0].get(timeout=LONG) == (0xFEEC, 0x81, vin)
        ecus[0].send(0xEF00, long, destination=0x81)
        assert heard[1].get(timeout=LONG) == (0xEF00, 0x80, long)
        ecus[1].send(0xEF00, long, destination=0x80)
        assert heard[0].get(timeout=LONG) == (0xEF00, 0x81, long)
    finally:
        for unit in units:
            unit.stop()
            unit.disconnect()
