"""Boards that are adapters of python-can, with its own `virtual` and `udp_multicast` as the real ones."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest

from canwire import (
    BadValue,
    BitTiming,
    ChannelMode,
    ErrorKind,
    ErrorState,
    EventKind,
    Feature,
    Frame,
    Hub,
    LineMode,
    Unsupported,
)
from canwire.boards.outside import capabilities_of
from canwire.drivers.outside import Trouble
from canwire.drivers.python_can.backends import BACKENDS
from canwire.drivers.python_can.opening import Setup, open_bus
from canwire.drivers.python_can.port import parse_port
from tests.cases import each
from tests.drivers.outside_bench import (
    AGES_S,
    TIMING,
    Program,
    a_frame,
    fresh_hub,
    gone,
    is_event,
    on_bus,
    trouble,
)
from tests.hubs import free_port

can = pytest.importorskip("can")
FD = LineMode(
    BitTiming.for_bit_rate(500_000, clock_hz=80_000_000),
    BitTiming.for_bit_rate(2_000_000, clock_hz=80_000_000),
    long_data=True,
    error_frames=True,
)


@pytest.fixture
def hub() -> Iterator[Hub]:
    made = fresh_hub()
    yield made
    made.close()


@pytest.fixture
def channel(request: pytest.FixtureRequest) -> str:
    """A channel of `virtual` that is this test's own."""
    return f"canwire {request.node.name}"


@pytest.fixture
def peer(channel: str) -> Iterator[Any]:
    bus = can.Bus(interface="virtual", channel=channel)
    yield bus
    bus.shutdown()


def plugged(hub: Hub, channel: str, mode: LineMode | None = None) -> Any:
    return Program(hub, hub.plug("python-can", port=f"virtual/{channel}"), mode)


@pytest.mark.realtime
@pytest.mark.conforms("PL-02", "PL-15")
def test_frames_of_every_kind_both_ways(hub: Hub, peer: Any, channel: str) -> None:
    program = plugged(hub, channel, FD).start()
    frames = [
        Frame(0x123),
        Frame(0x7FF, bytes(range(8))),
        Frame(0x1FFFFFFF, b"\x01", extended=True),
        Frame(0x1, remote=True, dlc=3),
        Frame(0x2, bytes(64), fd=True, bit_rate_switch=True),
        Frame(0x3, b"\x05", fd=True),
    ]
    program.send(*frames)
    messages = [peer.recv(AGES_S) for _ in frames]
    assert [program.wait(a_frame)[-1].self_received for _ in frames] == [True] * len(frames)
    for message in messages:
        peer.send(message)

    heard = [program.wait(a_frame)[-1] for _ in frames]
    assert heard == frames
    stamps = [frame.timestamp_ns for frame in heard]
    assert stamps == sorted(stamps)
    assert 0 < stamps[-1] <= hub.now_ns()
    status = program.status()
    assert (status.frames_sent, status.frames_received, status.state) == (6, 6, ErrorState.ERROR_ACTIVE)
    assert dict(hub.board("python-can").resources)["Interface"] == "virtual"


@pytest.mark.realtime
@pytest.mark.conforms("PL-02")
def test_udp_multicast(hub: Hub) -> None:
    pytest.importorskip("msgpack")
    group, place = "239.74.163.77", free_port()  # whatever else runs on this machine
    try:
        peer = can.Bus(interface="udp_multicast", channel=group, port=place)
    except OSError as error:
        pytest.skip(f"no multicast here: {error}")
    with peer:
        if peer.fileno() > 1000:
            pytest.skip(
                "python-can waits by select, which knows no descriptor above 1023; run this file alone"
            )
        program = Program(hub, hub.plug("python-can", port=f"udp_multicast/{group}?port={place}"))
        program.start()
        peer.send(can.Message(arbitration_id=0x123, is_extended_id=False, data=b"ab"))
        assert program.wait(a_frame)[-1] == Frame(0x123, b"ab")
        program.send(Frame(0x456))
        while (message := peer.recv(AGES_S)) is not None and message.arbitration_id != 0x456:
            pass
        assert message is not None


@pytest.mark.realtime
@pytest.mark.finding("python-can 10.7")
def test_what_an_interface_echoes_is_not_received(
    hub: Hub, peer: Any, channel: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As udp_multicast does; here `virtual`, told to, stands for it."""
    assert BACKENDS["udp_multicast"].echoes
    monkeypatch.setitem(BACKENDS, "virtual", replace(BACKENDS["virtual"], echoes=True))
    program = plugged(hub, f"{channel}?receive_own_messages=true").start()
    program.send(Frame(0x456), Frame(0x457))
    while (message := peer.recv(AGES_S)).arbitration_id != 0x457:
        pass
    heard = [program.wait(a_frame)[-1] for _ in range(2)]
    peer.send(message)  # the same frame from somebody else is one
    heard.append(program.wait(a_frame)[-1])
    assert [(frame.id, frame.self_received) for frame in heard] == [
        (0x456, True),
        (0x457, True),
        (0x457, False),
    ]
    assert program.status().frames_received == 1


@pytest.mark.realtime
@pytest.mark.conforms("PL-13")
def test_several_programs_share_one(hub: Hub, peer: Any, channel: str) -> None:
    program = plugged(hub, channel).start()
    others = [hub.open_channel(program.board.id, 0) for _ in range(3)]
    for other in others:
        other.set_up(ChannelMode(64, 64))
        other.activate()
    peer.send(can.Message(arbitration_id=1, is_extended_id=False))

    assert [one.receive(AGES_S) for one in (program.channel, *others)] == [Frame(1)] * 4


@pytest.mark.realtime
def test_many_frames_arrive_in_order(hub: Hub, peer: Any, channel: str) -> None:
    program = plugged(hub, channel).start()
    count = 2000
    messages = [can.Message(arbitration_id=k & 0x7FF, is_extended_id=False) for k in range(count)]
    sending = threading.Thread(target=lambda: [peer.send(message) for message in messages], daemon=True)
    sending.start()

    assert [program.wait(a_frame)[-1].id for _ in range(count)] == [k & 0x7FF for k in range(count)]


@pytest.mark.realtime
def test_error_frames_and_rubbish(hub: Hub, peer: Any, channel: str) -> None:
    program = plugged(hub, channel).start()
    rubbish = can.Message(arbitration_id=0x123, is_extended_id=False)
    rubbish.arbitration_id = 1 << 40
    peer.send(rubbish)
    peer.send(can.Message(is_error_frame=True, arbitration_id=0x20))
    found = program.wait(lambda one: is_event(one, EventKind.ERROR))

    assert [(one.kind, one.error) for one in found] == [(EventKind.ERROR, ErrorKind.OTHER)]
    assert program.status().errors == 1


class Adapter:
    """What `can.Bus` gives a test: a bus that breaks, refuses, and tells its state when it is told to."""

    def __init__(self) -> None:
        self.broken = self.missing = threading.Event()
        self.missing = threading.Event()
        self.refuses = threading.Event()
        self.opened: list[dict[str, Any]] = []
        self.sent: list[Any] = []
        self.state = can.BusState.ACTIVE
        self.channel_info = "a test's"
        self.closed = 0
        self.closing = threading.Event()

    def open(self, **arguments: Any) -> Adapter:
        if self.missing.is_set():
            raise can.CanInitializationError("no such adapter")
        self.opened.append(arguments)
        return self

    def recv(self, timeout: float) -> Any:
        if self.broken.wait(timeout):
            raise can.CanOperationError("unplugged")
        return None

    def send(self, message: Any, timeout: float) -> None:
        if self.refuses.is_set() or self.broken.is_set():
            raise can.CanOperationError("queue full")
        self.sent.append(message)

    def shutdown(self) -> None:
        self.closed += 1
        self.closing.set()


@pytest.fixture
def adapter(monkeypatch: pytest.MonkeyPatch) -> Adapter:
    made = Adapter()
    monkeypatch.setattr(can, "Bus", made.open)
    return made


@pytest.mark.realtime
@pytest.mark.conforms("PL-14")
def test_an_adapter_that_goes_is_opened_again(hub: Hub, adapter: Adapter) -> None:
    program = Program(hub, hub.plug("python-can", port="kvaser/0?single_handle=yes")).start()
    adapter.missing.set()
    adapter.broken.set()
    assert [one.kind for one in program.wait(gone)] == [EventKind.STATE]
    program.send(Frame(0x1))
    adapter.broken.clear()
    adapter.missing.clear()
    back = program.wait(a_frame)

    assert [one.kind for one in back[:-1]] == [EventKind.CHANGED, EventKind.STATE]
    assert back[-1] == Frame(0x1)
    assert adapter.opened[0] == adapter.opened[1]
    assert adapter.opened[0] == {
        "channel": "0",
        "interface": "kvaser",
        "ignore_config": True,
        "bitrate": 500_000,
        "single_handle": True,
    }
    program.control.close()
    program.channel.close()
    assert adapter.closing.wait(AGES_S)


@pytest.mark.realtime
def test_an_adapter_that_is_not_there_is_one_event(hub: Hub, adapter: Adapter) -> None:
    adapter.missing.set()
    program = Program(hub, hub.plug("python-can", port="pcan/PCAN_USBBUS1"))
    program.control.start()
    program.wait(trouble(Trouble.REFUSED))
    adapter.missing.clear()

    assert [one.kind for one in program.wait(on_bus)] == [EventKind.STATE]


@pytest.mark.realtime
@pytest.mark.conforms("PL-16")
def test_a_frame_that_is_refused_is_given_up(hub: Hub, adapter: Adapter) -> None:
    adapter.refuses.set()
    program = Program(hub, hub.plug("python-can", port="pcan/PCAN_USBBUS1")).start()
    program.send(Frame(0x1))

    found = program.wait(lambda one: is_event(one, EventKind.ABORTED))
    assert [(one.kind, one.code) for one in found] == [
        (EventKind.ERROR, Trouble.REFUSED),
        (EventKind.ABORTED, 0),
    ]
    adapter.refuses.clear()
    program.send(Frame(0x2))
    assert program.wait(a_frame)[-1] == Frame(0x2)


@pytest.mark.realtime
@pytest.mark.conforms("PL-18")
def test_its_state_where_it_tells(hub: Hub, adapter: Adapter) -> None:
    program = Program(hub, hub.plug("python-can", port="ixxat/0")).start()
    for state, expected in (
        (can.BusState.PASSIVE, ErrorState.ERROR_PASSIVE),
        (can.BusState.ERROR, ErrorState.BUS_OFF),
        (can.BusState.ACTIVE, ErrorState.ERROR_ACTIVE),
    ):
        adapter.state = state
        assert program.wait(lambda one: is_event(one, EventKind.STATE))[-1].state is expected


@pytest.mark.conforms("PL-19")
def test_listen_only_where_it_can(hub: Hub, adapter: Adapter) -> None:
    listening = LineMode(TIMING, listen_only=True)
    board = hub.plug("python-can", port="socketcan/can0")
    assert not board.lines[0].capabilities.can(Feature.LISTEN_ONLY)
    with hub.open_control(board.id, 0) as control, pytest.raises(Unsupported, match="LISTEN_ONLY"):
        control.initialise(listening)
    assert capabilities_of("pcan/PCAN_USBBUS1").can(Feature.LISTEN_ONLY)

    program = Program(hub, hub.plug("python-can", port="pcan/PCAN_USBBUS1"), listening)
    program.start()
    assert adapter.opened[0]["state"] is can.BusState.PASSIVE


def test_fd_settings_reach_the_adapter(adapter: Adapter) -> None:
    assert FD.timing is not None
    setup = Setup(FD.timing, FD.data_timing, False)
    open_bus(parse_port("kvaser/0"), setup)
    open_bus(parse_port("pcan/PCAN_USBBUS1"), setup)

    assert adapter.opened[0]["fd"] is True
    assert adapter.opened[0]["data_bitrate"] == 2_000_000
    timing = adapter.opened[1]["timing"]
    assert (timing.nom_bitrate, timing.data_bitrate, timing.f_clock) == (500_000, 2_000_000, 80_000_000)


def test_ports_are_text() -> None:
    port = parse_port("python-can:vector/1?app_name=CANoe&rx_queue_size=16384&x=0x10&y=1.5&z=no")
    assert (port.interface, port.channel) == ("vector", "1")
    assert port.options == {"app_name": "CANoe", "rx_queue_size": 16_384, "x": 16, "y": 1.5, "z": False}
    assert parse_port("virtual").channel is None


@each("text", ["", "/", "?a=b", "pcan/x?bitrate=5", "pcan/x?interface=y", "pcan/x?a b=5"])
def test_bad_ports(text: str) -> None:
    with pytest.raises(BadValue):
        parse_port(text)


@pytest.mark.finding("python-can 8")
def test_python_cans_slcan_loses_what_the_native_driver_does_not() -> None:
    with pytest.raises(BadValue, match="canwire share /dev/ttyACM0"):
        parse_port("python-can:slcan//dev/ttyACM0")
