"""What the ECUs put on the bus, read by Wireshark's own dissectors of CANopen and J1939."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from canwire import Lab, LabBus, LogEntry, create_log
from tests.missing import needs_program

pytest.importorskip("canopen")
j1939 = pytest.importorskip("j1939")

from canwire.ecus import CanopenEcu, J1939Ecu, LabCanopen  # noqa: E402

pytestmark = needs_program("tshark")


def read(bus: LabBus, tmp_path: Path, dissector: str, fields: Sequence[str]) -> list[tuple[str, ...]]:
    """Those fields of all frames of the bus, and what the dissector says of them in words."""
    path = tmp_path / "bus.pcapng"
    with create_log(path) as log:
        log.write_many([LogEntry(frame.timestamp_ns, bus.name, frame) for _, frame in bus.recent()])
    words = [
        "tshark",
        "-r",
        str(path),
        "-d",
        f"can.subdissector,{dissector}",
        "-T",
        "fields",
        "-E",
        "separator=;",
    ]
    for field in (*fields, "_ws.col.Info"):
        words += ["-e", field]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=True)
    return [tuple(row.split(";")) for row in done.stdout.splitlines()]


@pytest.mark.conforms("PP-04")
def test_canopen(tmp_path: Path) -> None:
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        bus.remember(1000)
        master, ecu = LabCanopen(bus.node("master")), CanopenEcu(5)
        bus.node("io", ecu)
        remote = master.add_node(5, CanopenEcu.EDS)
        lab.run_for(0.01)
        remote.sdo[0x1017].raw = 0
        assert remote.sdo["Device name"].raw == "canwire small I/O"
        remote.nmt.state = "OPERATIONAL"
        lab.run_for(0.01)
        master.sync.transmit()
        lab.run_for(0.01)
        master.send_message(0x205, b"\x5a")
        lab.run_for(0.01)
        ecu.emcy.send(0x4210, 0x08)
        lab.run_for(0.01)
        fields = ["canopen.node_id", "canopen.sdo.main_idx", "canopen.sdo.abort_code", "canopen.em.err_reg"]
        rows = read(bus, tmp_path, "canopen", fields)
    told = [row[-1].strip() for row in rows]
    assert told == [
        "NMT Error Control: Boot-up [0x5]",
        "NMT Error Control: Pre-operational [0x5]",
        "Default-SDO (rx): Initiate download request",
        "Default-SDO (tx): Initiate download response",
        "Default-SDO (rx): Initiate upload request",
        "Default-SDO (tx): Initiate upload response",
        *["Default-SDO (rx): Upload segment request", "Default-SDO (tx): Upload segment response"] * 3,
        "NMT: Start remote node [0x5]",
        "PDO1 (tx)",
        "SYNC",
        "PDO2 (tx)",
        "PDO1 (rx)",
        "EMCY",
    ]
    objects = [int(row[1], 0) for row in rows if row[1]]
    assert objects == [0x1017, 0x1017, 0x1008, 0x1008]
    assert [row[2] for row in rows if row[2]] == []
    assert int(rows[-1][3], 0) == 8
    assert {int(row[0], 0) for row in rows if row[0]} == {0, 5}  # NMT and SYNC are from node 0


@pytest.mark.conforms("PP-03")
def test_j1939(tmp_path: Path) -> None:
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=250_000)
        bus.remember(1000)
        ecu = J1939Ecu(0x80, groups={0xFEEC: b"CANWIRE01*"})
        bus.node("ecu", ecu)
        tester = J1939Ecu(0xF9, name=j1939.Name(identity_number=2))
        bus.node("tester", tester)
        lab.run_for(1)
        tester.application.send_request(0, 0xFEEC, 0x80)
        lab.run_for(0.5)
        ecu.send(0xEF00, b"to one only", destination=0xF9, priority=3)
        lab.run_until_idle()
        fields = ["j1939.priority", "j1939.pgn", "j1939.src_addr", "j1939.dst_addr"]
        rows = read(bus, tmp_path, "j1939", fields)
    numbers = [tuple(int(each, 0) for each in row[:4]) for row in rows]
    assert numbers == [
        (6, 0xEE00, 0x80, 0xFF),
        (6, 0xEE00, 0xF9, 0xFF),
        (6, 0xEA00, 0xF9, 0x80),
        (6, 0xEC00, 0x80, 0xFF),  # BAM, and its two packets
        *[(7, 0xEB00, 0x80, 0xFF)] * 2,
        (3, 0xEC00, 0x80, 0xF9),  # RTS
        (7, 0xEC00, 0xF9, 0x80),
        (7, 0xEB00, 0x80, 0xF9),
        (7, 0xEC00, 0xF9, 0x80),
        (7, 0xEB00, 0x80, 0xF9),
        (7, 0xEC00, 0xF9, 0x80),  # end of message
    ]
    assert "20 0a 00 02 ff ec fe 00" in rows[3][-1]
