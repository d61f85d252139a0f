"""Whatever frames come: the ECUs go on, and answer who asks properly afterwards."""

from __future__ import annotations

import hypothesis
import hypothesis.strategies as st
import pytest

from canwire import Frame, Lab

canopen = pytest.importorskip("canopen")
j1939 = pytest.importorskip("j1939")

from canwire.ecus import CanopenEcu, J1939Ecu, LabCanopen  # noqa: E402

BYTES = st.binary(max_size=8)
# those that mean something to node 5, and any
COB_IDS = st.one_of(st.sampled_from([0, 0x80, 0x205, 0x605, 0x585, 0x705, 0x7E5]), st.integers(0, 0x7FF))
SDO = st.builds(
    lambda head, rest: bytes([head]) + rest, st.integers(0, 255), st.binary(min_size=7, max_size=7)
)
CANOPEN = st.one_of(
    st.builds(Frame, COB_IDS, BYTES),
    st.builds(Frame, st.just(0x605), SDO),
    st.builds(
        Frame, st.just(0), st.sampled_from([b"\1\0", b"\2\5", b"\x80\0", b"\x81\5", b"\x82\0", b"\7\5"])
    ),
    st.builds(lambda id: Frame(id, b"", remote=True), COB_IDS),
)
GROUPS = st.sampled_from([0xEA, 0xEB, 0xEC, 0xE8, 0xEE, 0xEF, 0xFE])
CONTROL = st.sampled_from([16, 17, 19, 32, 255, 0])
J1939 = st.builds(
    lambda priority, group, destination, source, data: Frame(
        priority << 26 | group << 16 | destination << 8 | source, data, extended=True
    ),
    st.integers(0, 7),
    GROUPS,
    st.sampled_from([0x80, 0x81, 0xFF, 0x10]),
    st.sampled_from([0x80, 0x81, 0xF9, 0xFE, 0xFF, 0x10]),
    st.one_of(
        BYTES, st.builds(lambda control, rest: bytes([control]) + rest, CONTROL, st.binary(max_size=7))
    ),
)
SHORT = hypothesis.settings(max_examples=40)


@SHORT
@hypothesis.given(frames=st.lists(CANOPEN, max_size=30))
def test_canopen(frames: list[Frame]) -> None:
    """A reset of the node brings it back from any state."""
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        ecu = CanopenEcu(5)
        bus.node("io", ecu)
        rubbish = bus.node("rubbish")
        for frame in frames:
            rubbish.send(frame)
            lab.run_for(0.001)
        remote = LabCanopen(bus.node("master")).add_node(5, CanopenEcu.EDS)
        remote.nmt.state = "RESET"
        remote.nmt.wait_for_bootup(1)
        assert remote.sdo["Device name"].raw == "canwire small I/O"
        assert remote.sdo["Label"].raw == "not labelled"


@SHORT
@hypothesis.given(frames=st.lists(J1939, max_size=30))
def test_j1939(frames: list[Frame]) -> None:
    """Whatever address it has ended up with, it answers there once transfers that nobody goes on with are over."""
    heard: list[tuple[int, int, bytes]] = []
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=250_000)
        ecu = J1939Ecu(0x80, groups={0xEF00: b"here"})
        bus.node("ecu", ecu)
        lab.run_for(1)
        rubbish = bus.node("rubbish")
        for frame in frames:
            rubbish.send(frame)
            lab.run_for(0.002)
        rubbish.close()
        tester = J1939Ecu(
            0xF8, name=j1939.Name(identity_number=7), on_message=lambda *words: heard.append(words)
        )
        bus.node("tester", tester)
        lab.run_for(3)
        lab.run_until_idle()
        assert ecu.address is not None
        tester.application.send_request(0, 0xEF00, ecu.address)
        lab.run_for(0.1)
        assert heard[-1:] == [(0xEF00, ecu.address, b"here")]
