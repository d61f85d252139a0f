"""LIN slaves on lines of a plain hub that answer node configuration, and requests through the transport layer."""

from __future__ import annotations

import pytest

from canwire import (
    BadValue,
    Busy,
    Hub,
    LinConfiguration,
    LinControl,
    LinFrame,
    LinMode,
    LinMonitorMode,
    LinNodeAttributes,
    LinProduct,
    LinSchedule,
    LinSlot,
    NotInitialised,
    NotReceived,
    Unsupported,
    WrongState,
)
from canwire.boards.config.configuration import Config
from canwire.boards.config.tables import BoardConfig, BusConfig
from tests.hub.in_memory import Bench, bench_of

pytestmark = pytest.mark.conforms("N-47")

RATE = 19_200
WORLD = Config(
    bus=(BusConfig(name="can0"), BusConfig(name="lin0", type="lin")),
    board=(
        BoardConfig(kind="usb-to-can-fd", serial="HW000001"),
        BoardConfig(kind="usb-to-can-fd", serial="HW000002"),
    ),
)
ATTRIBUTES = LinNodeAttributes(
    LinProduct(0x1234, 0x5678, 1), nad=0x11, frames={0: 0x10, 1: 0x20}, serial=7, identifiers={32: b"abcde"}
)
IDENTITY = bytes.fromhex("F2 3412 7856 01")
READ = bytes.fromhex("B200 FF7F FFFF")
SAVE = b"\xb6"


bench = bench_of(WORLD)


@pytest.fixture
def hub(bench: Bench) -> Hub:
    return bench.hub("master")


def control_of(hub: Hub, board: str, *, master: bool) -> LinControl:
    control = hub.open_lin_control(hub.board(board).id, 2)
    control.initialise(LinMode(master, RATE, errors=True))
    control.start()
    return control


@pytest.fixture
def master(hub: Hub) -> LinControl:
    return control_of(hub, "HW000001", master=True)


@pytest.fixture
def slave(bench: Bench) -> LinControl:
    """Of another program; its frame 1 (0x20) has data."""
    control = control_of(bench.hub("slave"), "HW000002", master=False)
    control.respond(LinFrame(0x20, b"\x05"))
    control.configure(ATTRIBUTES)
    return control


def test_a_slave_says_who_it_is(master: LinControl, slave: LinControl) -> None:
    assert master.request(0x11, READ) == IDENTITY
    assert master.request(0x11, bytes.fromhex("B201 FF7F FFFF")) == bytes.fromhex("F2 07000000")
    assert master.request(0x11, bytes.fromhex("B220 FF7F FFFF")) == b"\xf2abcde"
    assert master.request(0x11, bytes.fromhex("B221 FF7F FFFF"))[:2] == b"\x7f\xb2"


def test_its_frames_move(hub: Hub, master: LinControl, slave: LinControl) -> None:
    assert slave.configuration() == LinConfiguration(0x11, {0: 0x10, 1: 0x20})
    assert master.request(0x11, bytes.fromhex("B701 8EFFFFFF")) == b"\xf7"  # 0x0E with its parity
    assert slave.configuration().frames == {0: 0x10, 1: 0x0E}
    with hub.open_monitor(hub.board("HW000001").id, 2) as monitor:
        monitor.set_up(LinMonitorMode(64))
        monitor.activate()
        for id in (0x20, 0x0E):
            master.send(LinFrame(id, header_only=True))
            hub.run_for(0.02)
        heard = [monitor.receive() for _ in range(2)]
    assert [(one.id, one.data) for one in heard if isinstance(one, LinFrame)] == [(0x0E, b"\x05")]


def test_what_was_not_saved_is_forgotten_without_power(master: LinControl, slave: LinControl) -> None:
    change = bytes.fromhex("B300 01 00 00 22")  # conditional: byte 1 of identifier 0, no bit of it counts
    assert master.request(0x11, change)[0] == 0xF3
    assert slave.configuration().nad == 0x22
    slave.power_up()
    assert slave.configuration().nad == 0x11
    master.request(0x11, change)
    assert master.request(0x22, SAVE) == b"\xf6"
    slave.power_up()
    assert slave.configuration().nad == 0x22


def test_nobody_answers(hub: Hub, master: LinControl, slave: LinControl) -> None:
    before_ns = hub.now_ns()
    with pytest.raises(NotReceived, match=r"no response of NAD 0x33"):
        master.request(0x33, READ, within=0.3)
    assert 290_000_000 <= hub.now_ns() - before_ns <= 310_000_000
    assert master.request(0x7E, bytes.fromhex("3E00")) == b""  # functional: there is no response
    assert master.request(0x11, READ) == IDENTITY


def test_requests_beside_a_schedule(hub: Hub, master: LinControl, slave: LinControl) -> None:
    master.run_schedule(LinSchedule.of([LinSlot.frame(0x20, delay_ns=20_000_000, length=1)], "one"))
    for _ in range(5):
        assert master.request(0x11, READ, within=3.0) == IDENTITY
    before = master.status().status.frames_received
    hub.run_for(0.5)
    assert master.status().status.frames_received - before >= 20


def test_a_long_request_goes_out_frame_by_frame(hub: Hub, master: LinControl, slave: LinControl) -> None:
    with hub.open_monitor(hub.board("HW000002").id, 2) as monitor:
        monitor.set_up(LinMonitorMode(256))
        monitor.activate()
        with pytest.raises(NotReceived):  # nobody knows this service
            master.request(0x11, bytes([0x22, *range(40)]), within=0.5)
        heard = [one.data[:2].hex() for one in iter(monitor.receive, None) if isinstance(one, LinFrame)]
    assert heard == ["1110", *(f"112{number}" for number in range(1, 7))]


def test_who_may_ask_and_answer(bench: Bench, hub: Hub, master: LinControl, slave: LinControl) -> None:
    with pytest.raises(WrongState, match="a slave sends nothing"):
        slave.request(0x11, READ)
    with pytest.raises(WrongState, match="initialise the line as slave"):
        master.configure(ATTRIBUTES)
    with pytest.raises(WrongState, match="no node configuration"):
        master.configuration()
    with pytest.raises(WrongState, match="no node configuration"):
        master.power_up()
    with pytest.raises(Unsupported, match="data_dump and service"):
        slave.configure(LinNodeAttributes(LinProduct(1, 2), service=lambda payload: payload))
    for nad, payload, within in ((0x11, b"", 1.0), (0x100, READ, 1.0), (0x11, READ, 0.0), (0x11, READ, 1e5)):
        with pytest.raises(BadValue):
            master.request(nad, payload, within=within)
    for wrong in ((None, READ), (0x11, None), (0x11, "B2")):
        with pytest.raises((TypeError, BadValue)):
            master.request(*wrong)  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        slave.configure(None)  # type: ignore[arg-type]
    assert master.request(0x11, READ) == IDENTITY


def test_one_request_at_a_time(bench: Bench, hub: Hub, master: LinControl, slave: LinControl) -> None:
    link = bench.link(hub)
    seen: list[type[Exception]] = []

    def another() -> None:
        link.on_wait = None
        try:
            master.request(0x11, READ)
        except Busy as error:
            seen.append(type(error))
        hub.run_for(0.5)

    link.on_wait = another
    assert master.request(0x11, READ) == IDENTITY
    assert seen == [Busy]


def test_a_line_that_is_reset_meanwhile(
    bench: Bench, hub: Hub, master: LinControl, slave: LinControl
) -> None:
    link = bench.link(hub)

    def reset() -> None:
        link.on_wait = None
        master.reset()
        hub.run_for(0.5)

    link.on_wait = reset
    with pytest.raises(NotInitialised):
        master.request(0x33, READ)
    assert master.status().status.monitors == 0
    master.initialise(LinMode(True, RATE))
    master.start()
    assert master.request(0x11, READ) == IDENTITY


@pytest.mark.parametrize("how", ["reset", "initialise"])
def test_a_configuration_ends_with_the_settings(master: LinControl, slave: LinControl, how: str) -> None:
    if how == "reset":
        slave.reset()
    slave.initialise(LinMode(False, RATE))
    slave.start()
    with pytest.raises(NotReceived):
        master.request(0x11, READ, within=0.2)
    with pytest.raises(WrongState):
        slave.configuration()
    assert slave.status().status.monitors == 0
    slave.configure(ATTRIBUTES)
    slave.configure(LinNodeAttributes(LinProduct(1, 2), nad=0x44))  # in place of that
    assert slave.status().status.monitors == 1
    assert master.request(0x44, READ) == bytes.fromhex("F2 0100 0200 00")
    with pytest.raises(NotReceived):
        master.request(0x11, READ, within=0.2)
