"""The small CANopen ECU, asked by canopen's own master in the lab's time."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from canwire import BadValue, Frame, Lab, LabNode

canopen = pytest.importorskip("canopen")

from canopen.nmt import NmtError  # noqa: E402

from canwire.ecus import CanopenEcu, LabCanopen  # noqa: E402

pytestmark = pytest.mark.conforms("PP-04")
MS = 1_000_000


class Bench:
    """A master and an ECU with number 5 on a bus of 500 kbit/s, and somebody who hears everything."""

    def __init__(self, lab: Lab) -> None:
        self.lab = lab
        self.bus = bus = lab.can_bus("can0", bit_rate=500_000)
        self.master = LabCanopen(bus.node("master"))
        self.listener = bus.node("listener")
        self.ecu = CanopenEcu(5)
        bus.node("io", self.ecu)
        self.remote: Any = self.master.add_node(5, CanopenEcu.EDS)

    def heard(self, id: int) -> list[Frame]:
        """What came with this identifier since the last call; all else is dropped."""
        return [frame for frame in self.listener.receive_many(100_000) if frame.id == id]

    def start(self) -> None:
        """Operational, and the PDOs known."""
        self.remote.tpdo.read()
        self.remote.rpdo.read()
        self.remote.nmt.state = "OPERATIONAL"
        self.lab.run_for(0.01)
        self.listener.receive_many(100_000)

    def sync(self) -> None:
        self.master.sync.transmit()
        self.lab.run_for(0.001)


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Lab() as lab:
        yield Bench(lab)


def aborted(call: Any, *words: Any) -> int:
    with pytest.raises(canopen.SdoAbortedError) as error:
        call(*words)
    return int(error.value.code)


@pytest.mark.smoke
def test_it_boots_and_beats(bench: Bench) -> None:
    """The boot-up message, then heartbeats each second, which is the dictionary's time."""
    bench.remote.nmt.wait_for_bootup(1)
    assert bench.remote.nmt.state == "PRE-OPERATIONAL"
    bench.lab.run_for(3.5)
    beats = bench.heard(0x705)
    assert [frame.data for frame in beats] == [b"\0", b"\x7f", b"\x7f", b"\x7f", b"\x7f"]
    apart = [after.timestamp_ns - before.timestamp_ns for before, after in pairwise(beats[1:])]
    assert all(abs(each - 1000 * MS) < 1 * MS for each in apart)


def test_the_heartbeat_is_the_master_s_to_set(bench: Bench) -> None:
    bench.remote.sdo[0x1017].raw = 50
    bench.heard(0x705)
    bench.lab.run_for(0.5)
    assert len(bench.heard(0x705)) == 10
    bench.remote.nmt.state = "OPERATIONAL"
    assert bench.remote.nmt.wait_for_heartbeat(0.1) == "OPERATIONAL"
    bench.remote.sdo[0x1017].raw = 0
    bench.lab.run_for(0.01)
    bench.heard(0x705)
    with pytest.raises(NmtError, match="heartbeat"):
        bench.remote.nmt.wait_for_heartbeat(5)
    assert bench.heard(0x705) == []


def test_sdo_expedited(bench: Bench) -> None:
    remote = bench.remote
    assert remote.sdo[0x1000].raw == 0x000F_0191
    assert remote.sdo[0x1018][2].raw == 1
    remote.sdo["Outputs"][1].raw = 0xA5
    assert bench.ecu.sdo["Outputs"][1].raw == remote.sdo["Outputs"][1].raw == 0xA5


@pytest.mark.parametrize("size", [5, 7, 8, 14, 255, 4096])
def test_sdo_segmented(bench: Bench, size: int) -> None:
    assert bench.remote.sdo["Device name"].raw == "canwire small I/O"
    program = bytes(number * 7 & 0xFF for number in range(size))
    bench.remote.sdo.download(0x2001, 0, program)
    assert bench.ecu.sdo.upload(0x2001, 0) == program
    assert bench.remote.sdo.upload(0x2001, 0) == program


def test_sdo_refusals_are_canopen_s_own(bench: Bench) -> None:
    sdo = bench.remote.sdo
    assert aborted(sdo.upload, 0x3000, 0) == 0x0602_0000  # no such object
    assert aborted(sdo.upload, 0x1018, 9) == 0x0609_0011  # no such sub-index
    assert aborted(sdo.download, 0x1000, 0, bytes(4)) == 0x0601_0002  # read only
    assert aborted(sdo.download, 0x1017, 0, bytes(4)) == 0x0607_0010  # another length
    assert aborted(sdo.download, 0x1003, 0, b"\1") == 0x0609_0030  # only 0 forgets the errors


def test_no_answer_ends_in_the_lab_s_time() -> None:
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        bus.node("somebody")
        remote = LabCanopen(bus.node("master")).add_node(9, CanopenEcu.EDS)
        remote.sdo.RESPONSE_TIMEOUT = 2.5
        with pytest.raises(canopen.SdoCommunicationError):
            remote.sdo.upload(0x1000, 0)
        assert 2500 * MS <= lab.now_ns < 2501 * MS
        with pytest.raises(NmtError, match="boot-up"):
            remote.nmt.wait_for_bootup(10)
        assert 12_500 * MS <= lab.now_ns < 12_501 * MS


def test_a_pdo_on_change(bench: Bench) -> None:
    """Sent once when it becomes operational, then with each new value, not with the same one again."""
    remote, ecu = bench.remote, bench.ecu
    remote.tpdo.read()
    bench.heard(0x185)
    remote.nmt.state = "OPERATIONAL"
    assert remote.tpdo[1].wait_for_reception(0.1) is not None
    for value in (0x5A, 0x5A, 0x5B):
        ecu.sdo["Inputs"][1].raw = value
        bench.lab.run_for(0.01)
    assert [frame.data for frame in bench.heard(0x185)] == [b"\0", b"\x5a", b"\x5b"]
    assert remote.tpdo[1]["Inputs.Inputs 1 to 8"].raw == 0x5B
    remote.nmt.state = "PRE-OPERATIONAL"
    bench.lab.run_for(0.01)
    ecu.sdo["Inputs"][1].raw = 0
    assert remote.tpdo[1].wait_for_reception(1.0) is None
    assert bench.heard(0x185) == []


def test_the_manufacturer_s_type_is_on_change_too(bench: Bench) -> None:
    """Type 254, as 255: sent when it is set up anew, and with each new value."""
    bench.start()
    bench.heard(0x185)
    bench.remote.sdo[0x1800][2].raw = 254
    bench.lab.run_for(0.01)
    bench.ecu.sdo["Inputs"][1].raw = 0x5A
    bench.lab.run_for(0.01)
    assert [frame.data for frame in bench.heard(0x185)] == [b"\0", b"\x5a"]


def test_a_pdo_by_its_event_timer(bench: Bench) -> None:
    """Every 20 ms; a change is sent at once, and the timer begins anew."""
    bench.remote.sdo[0x1800][5].raw = 20
    bench.start()
    bench.lab.run_until(1_000 * MS)
    bench.heard(0x185)
    bench.lab.run_for(0.2)
    frames = bench.heard(0x185)
    assert len(frames) == 10
    due_ns = frames[-1].timestamp_ns + 20 * MS
    bench.lab.run_until(due_ns - 5 * MS)
    bench.ecu.sdo["Inputs"][1].raw = 1
    bench.lab.run_until(due_ns + 40 * MS)
    changed = bench.heard(0x185)
    assert [frame.data for frame in changed] == [b"\1"] * 3
    assert changed[0].timestamp_ns == pytest.approx(due_ns - 5 * MS, abs=MS)
    assert changed[1].timestamp_ns - changed[0].timestamp_ns == pytest.approx(20 * MS, abs=MS)


def test_pdos_on_sync(bench: Bench) -> None:
    """Type 1 with each SYNC, type 3 with every third, type 0 with the next after a change."""
    ecu, remote = bench.ecu, bench.remote
    bench.start()
    ecu.sdo["Analogue inputs"][1].raw = -1234
    ecu.sdo["Analogue inputs"][2].raw = 77
    assert bench.heard(0x285) == []
    bench.sync()
    assert [var.raw for var in remote.tpdo[2]] == [-1234, 77]
    bench.sync()
    assert len(bench.heard(0x285)) == 2
    remote.sdo[0x1801][2].raw = 3
    for _ in range(6):
        bench.sync()
    assert len(bench.heard(0x285)) == 2
    remote.sdo[0x1801][2].raw = 0
    for value in (1, 1, 2):
        ecu.sdo["Analogue inputs"][1].raw = value
        bench.sync()
        bench.sync()
    assert len(bench.heard(0x285)) == 2


def test_an_rpdo_goes_into_the_dictionary(bench: Bench) -> None:
    written: list[tuple[int, bytes]] = []
    bench.ecu.add_write_callback(lambda index, subindex, od, data: written.append((index, bytes(data))))
    outputs = bench.remote.rpdo[1]
    bench.remote.rpdo.read()
    outputs[0].raw = 0x3C
    outputs.transmit()
    bench.lab.run_for(0.01)
    assert bench.ecu.sdo["Outputs"][1].raw == 0  # not operational yet
    bench.start()
    outputs[0].raw = 0x3C
    outputs.transmit()
    bench.lab.run_for(0.01)
    assert bench.ecu.sdo["Outputs"][1].raw == 0x3C
    assert written == [(0x6200, b"\x3c")]


def test_an_rpdo_on_sync_waits_for_it(bench: Bench) -> None:
    bench.remote.sdo[0x1400][2].raw = 1
    bench.start()
    bench.remote.rpdo[1][0].raw = 0x81
    bench.remote.rpdo[1].transmit()
    bench.lab.run_for(0.01)
    assert bench.ecu.sdo["Outputs"][1].raw == 0
    bench.sync()
    assert bench.ecu.sdo["Outputs"][1].raw == 0x81


def test_an_rpdo_that_is_too_short_is_an_emergency(bench: Bench) -> None:
    bench.start()
    bench.master.send_message(0x205, b"")
    assert bench.remote.emcy.wait(timeout=0.1).code == 0x8210
    assert (bench.ecu.pdos.short, bench.ecu.sdo["Outputs"][1].raw) == (1, 0)


def test_a_master_maps_other_objects(bench: Bench) -> None:
    """canopen's own `save`: off, other entries, on again with another identifier; also while it is operational."""
    for operational in (False, True):
        if operational:
            bench.start()
        pdo = bench.remote.tpdo[1]
        bench.remote.tpdo.read()
        pdo.clear()
        pdo.add_variable("Analogue inputs", 2)
        pdo.add_variable("Inputs", 1)
        pdo.cob_id, pdo.trans_type, pdo.enabled = 0x1B5 + operational, 255, True
        pdo.save()
        bench.start()
        bench.ecu.sdo["Analogue inputs"][2].raw = 0x0102 + operational
        bench.lab.run_for(0.01)
        assert [frame.data for frame in bench.heard(pdo.cob_id)] == [bytes([2 + operational, 1, 0])]


def test_emergencies(bench: Bench) -> None:
    """Sent, in the error register, and in the list of errors with the newest first until somebody writes 0."""
    bench.ecu.emcy.send(0x4210, 0x08, b"hot!!")
    told = bench.remote.emcy.wait(timeout=0.1)
    assert (told.code, told.register, told.data) == (0x4210, 8, b"hot!!")
    bench.ecu.emcy.send(0x3100, 0x04)
    sdo = bench.remote.sdo
    assert [sdo[0x1003][number].raw for number in (0, 1, 2)] == [2, 0x0000_3100, 0x6F68_4210]
    assert sdo[0x1001].raw == 4
    bench.ecu.emcy.reset()
    bench.lab.run_for(0.01)
    assert (bench.remote.emcy.active, len(bench.remote.emcy.log), sdo[0x1001].raw) == ([], 3, 0)
    sdo[0x1003][0].raw = 0
    assert sdo[0x1003][0].raw == 0
    assert aborted(lambda: sdo[0x1003][1].raw) == 0x060A_0023
    for number in range(6):
        bench.ecu.emcy.send(0xFF00 + number)
    assert [sdo[0x1003][number].raw for number in range(5)] == [4, 0xFF05, 0xFF04, 0xFF03, 0xFF02]
    sdo[0x1014].raw = 0x8000_0085
    bench.heard(0x85)
    bench.ecu.emcy.send(0x1000)
    bench.lab.run_for(0.01)
    assert bench.heard(0x85) == []


def test_a_stopped_ecu_beats_and_is_silent_else(bench: Bench) -> None:
    bench.start()
    bench.remote.nmt.state = "STOPPED"
    bench.lab.run_for(0.01)
    bench.listener.receive_many(1000)
    bench.ecu.sdo["Inputs"][1].raw = 9
    bench.ecu.emcy.send(0x1000, 1)
    bench.sync()
    with pytest.raises(canopen.SdoCommunicationError):
        bench.remote.sdo.upload(0x1000, 0)
    assert bench.remote.nmt.wait_for_heartbeat(2) == "STOPPED"
    frames = bench.listener.receive_many(1000)
    assert {frame.id for frame in frames} == {0x80, 0x605, 0x705}
    bench.remote.nmt.state = "PRE-OPERATIONAL"
    assert bench.remote.sdo[0x1001].raw == 1


@pytest.mark.parametrize(("command", "label"), [("RESET", "not labelled"), ("RESET COMMUNICATION", "mine")])
def test_resets_take_values_back(bench: Bench, command: str, label: str) -> None:
    """All of them, or those of the communication alone; it boots again, pre-operational."""
    bench.start()
    bench.remote.sdo["Label"].raw = "mine"
    bench.remote.sdo[0x1017].raw = 100
    bench.heard(0x705)
    bench.remote.nmt.state = command
    bench.remote.nmt.wait_for_bootup(1)
    assert (bench.ecu.nmt.state, bench.ecu.resets) == ("PRE-OPERATIONAL", 1)
    assert bench.remote.sdo["Label"].raw == label
    assert bench.remote.sdo[0x1017].raw == 1000
    bench.ecu.sdo["Inputs"][1].raw = 1
    bench.lab.run_for(0.01)
    assert bench.heard(0x185) == []


def test_the_master_may_speak_to_all(bench: Bench) -> None:
    second = CanopenEcu(6)
    bench.bus.node("second", second)
    bench.master.nmt.state = "OPERATIONAL"
    bench.lab.run_for(0.01)
    assert [ecu.nmt.state for ecu in (bench.ecu, second)] == ["OPERATIONAL"] * 2
    bench.master.scanner.reset()
    bench.master.scanner.search()
    bench.lab.run_for(0.1)
    assert sorted(bench.master.scanner.nodes) == [5, 6]


def test_a_dictionary_of_one_s_own(tmp_path: Path) -> None:
    """canopen's, with hardly an object; and an EDS file, whose node number goes into its identifiers."""
    bare = canopen.ObjectDictionary()
    variable = canopen.objectdictionary.ODVariable("Speed", 0x2000)
    variable.data_type, variable.default = canopen.objectdictionary.UNSIGNED16, 1500
    bare.add_object(variable)
    file = tmp_path / "own.eds"
    file.write_text(Path(CanopenEcu.EDS).read_text().replace("not labelled", "own"))
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        master = LabCanopen(bus.node("master"))
        bus.node("bare", CanopenEcu(3, bare))
        bus.node("own", CanopenEcu(4, file))
        assert master.add_node(3, bare).sdo["Speed"].raw == 1500
        own = master.add_node(4, str(file))
        assert (own.sdo["Label"].raw, own.sdo[0x1800][1].raw) == ("own", 0x184)
        bus.nodes["bare"].expect(0x704, within=2)


@pytest.mark.parametrize(
    ("told", "instead"),
    [
        ("DefaultValue=$NODEID+0x180", "DefaultValue="),
        ("0x60000108", "0x60000120"),
        ("0x60000108", "0x20000140"),
    ],
    ids=["no identifier", "more than the object has", "a text"],
)
def test_a_pdo_that_cannot_be_is_off(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, told: str, instead: str
) -> None:
    file = tmp_path / "open.eds"
    file.write_text(Path(CanopenEcu.EDS).read_text().replace(told, instead))
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        listener, ecu = bus.node("listener"), CanopenEcu(4, file)
        bus.node("ecu", ecu)
        ecu.nmt.state = "OPERATIONAL"
        ecu.sdo["Inputs"][1].raw = 1
        lab.run_for(0.1)
        assert {frame.id for frame in listener.receive_many(100)} == {0x704}
    assert "TPDO communication parameter 1 is off" in caplog.text


def test_a_file_without_values(tmp_path: Path) -> None:
    """The usual numbers, zeros in PDOs; a mapped object that is not there is left out."""
    text, wanted = (
        Path(CanopenEcu.EDS).read_text(),
        {"1005", "1014", "1017", "6000sub1", "6401sub1", "6401sub2"},
    )
    sections = [f"[{part}" for part in text.split("[")[1:]]
    stripped = [
        re.sub("DefaultValue=.*", "DefaultValue=", part) if part[1 : part.index("]")] in wanted else part
        for part in sections
    ]
    file = tmp_path / "no-values.eds"
    file.write_text("".join(stripped).replace("0x62000108", "0x63000108"))
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        listener, ecu, master = bus.node("listener"), CanopenEcu(4, file), LabCanopen(bus.node("master"))
        bus.node("ecu", ecu)
        ecu.nmt.state = "OPERATIONAL"
        master.sync.transmit()
        lab.run_for(2)
        ecu.emcy.send(0x1000)
        master.send_message(0x204, b"\xff")
        lab.run_for(0.1)
        frames = {frame.id: frame.data for frame in listener.receive_many(100)}
        assert frames.pop(0x84) == bytes.fromhex("0010 00 0000000000")
        assert frames == {0x704: b"\0", 0x184: b"\0", 0x284: bytes(4), 0x80: b"", 0x204: b"\xff"}
        assert ecu.network.errors == []


def test_periodic_messages_of_the_master(bench: Bench) -> None:
    bench.start()
    bench.master.sync.start(0.01)
    bench.lab.run_for(0.095)
    bench.master.sync.stop()
    bench.lab.run_for(0.1)
    assert len(bench.heard(0x285)) == 10
    for period in (0, -1):
        with pytest.raises(BadValue, match="at least one nanosecond"):
            bench.master.send_periodic(0x80, b"", period)


def test_a_bus_where_nobody_acknowledges_fills_no_memory() -> None:
    """Heartbeats for which there is no room are counted."""
    with Lab() as lab:
        ecu = CanopenEcu(5)
        node: LabNode = lab.can_bus("can0", bit_rate=500_000).node("io", ecu, transmit_queue=16)
        lab.run_for(60)
        assert node.pending <= 17
        assert ecu.nmt._send_task.missed >= 40


def test_networks_end(bench: Bench) -> None:
    with pytest.raises(BadValue, match="can0/master already"):
        bench.master.connect(interface="virtual")
    with pytest.raises(BadValue, match="1021"):
        bench.master.add_node(7, upload_eds=True)
    bench.start()
    network = bench.ecu.network
    del network[5]
    network.disconnect()
    bench.lab.run_for(5)
    assert bench.heard(0x705) == []
    bench.ecu.remove_network()
    assert repr(bench.master).startswith("<CANopen on can0/master: nodes 5")
    assert repr(bench.ecu) == "<CANopen ECU 5: OPERATIONAL, 0 resets>"


def test_in_real_time() -> None:
    """The same objects while a thread lets time pass."""
    with Lab(time="real") as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        master = LabCanopen(bus.node("master"))
        bus.node("io", CanopenEcu(5))
        remote = master.add_node(5, CanopenEcu.EDS)
        remote.sdo.RESPONSE_TIMEOUT = 30
        remote.sdo["Label"].raw = "in real time"
        assert remote.sdo["Label"].raw == "in real time"
        remote.sdo[0x1017].raw = 20
        assert remote.nmt.wait_for_heartbeat(30) == "PRE-OPERATIONAL"
