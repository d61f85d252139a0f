"""What an outside examination of the dialect found, one test for each point; its numbers stand in the marks."""

from __future__ import annotations

import pytest

from canwire import ErrorState, Frame, HubChannel, InUse, LineStatus, candrv
from canwire.candrv import (
    CAN_ACCEPTANCE_FILTER,
    CanbusEvent,
    CandrvError,
    CanMode,
    Command,
    FrameFormat,
    Handle,
    Win32Error,
)
from canwire.candrv.event_queue import Event
from canwire.candrv.ioctl import control
from canwire.candrv.registry.registry import RegistryStore
from tests.candrv.bench import Bench

RECEIVED, TRANSMITTED, ABORTED = CanbusEvent.RECEIVED, CanbusEvent.TRANSMITTED, CanbusEvent.ABORTED
CHANGED = CanbusEvent.DEVICE_CHANGED
EFLG, CANINTE = 0x2D, 0x2B


def events(handle: Handle) -> list[Event]:
    """Everything that waits now."""
    return [handle.read_event() for _ in range(handle.waiting)]


def received(handle: Handle) -> list[tuple[int, bytes]]:
    return [(event.identifier, event.data) for event in events(handle) if event.event == RECEIVED]


def kinds(handle: Handle) -> list[CanbusEvent]:
    return [event.type for event in events(handle)]


def refusal(call: object, *args: object, **kwargs: object) -> int:
    with pytest.raises(CandrvError) as raised:
        call(*args, **kwargs)  # type: ignore[operator]
    return raised.value.code


# A5: what cannot be


@pytest.mark.finding("candrv A5")
@pytest.mark.parametrize(
    "wrong", [{"mode": 9}, {"mode": 2}, {"format": 3}, {"rate": 0}, {"rate": 500_000, "mode": 9}]
)
def test_what_cannot_be_is_refused_and_changes_nothing(bench: Bench, wrong: dict[str, int]) -> None:
    handle = bench.open()
    before = handle.device.state()
    assert refusal(handle.device.change, **wrong) == Win32Error.ERROR_INVALID_PARAMETER
    assert handle.device.state() == before
    assert kinds(handle) == []
    assert handle.properties().nRegisters == 128
    assert handle.can_mode == CanMode.CAN_2_0_A


@pytest.mark.finding("candrv A5")
def test_whatever_a_device_refuses_has_a_code(bench: Bench) -> None:
    """Also what the porting page does without the handle's own methods."""
    device = bench.open().device
    assert refusal(device.read_register, 200, reset_mode=False) == Win32Error.ERROR_INVALID_PARAMETER
    assert refusal(device.write_register, 200, 0, reset_mode=True) == Win32Error.ERROR_INVALID_PARAMETER


@pytest.mark.finding("candrv A5")
def test_a_note_that_says_what_cannot_be_is_none(bench: Bench) -> None:
    """Whoever wrote it: it must not fail in every program on the hub."""
    handle = bench.open()
    board = bench.hub.board(str(handle.device.board.hardware_id)).id
    with bench.hub.open_control(board, 0, kin="CANDRV") as lease:
        lease.annotate(b"CIDn\x09\x09")
    assert (handle.can_mode, handle.frame_format) == (CanMode.CAN_2_0_B, FrameFormat.DEFAULT)
    assert refusal(handle.command, 99) == Win32Error.ERROR_INVALID_PARAMETER


@pytest.mark.finding("candrv A5")
@pytest.mark.conforms("FS-43")
def test_rates_by_their_number_in_the_table(bench: Bench) -> None:
    handle = bench.open()
    handle.baud_rate_constant = 4
    assert (handle.baud_rate_constant, handle.baud_rate) == (4, 125_000)
    with pytest.raises(CandrvError) as raised:
        handle.baud_rate_constant = 99
    assert raised.value.code == Win32Error.ERROR_INVALID_PARAMETER
    assert handle.baud_rate == 125_000


# A6, ruling 31


@pytest.mark.finding("candrv A6")
@pytest.mark.conforms("FS-44")
@pytest.mark.parametrize("format", list(FrameFormat))
@pytest.mark.parametrize("mode", list(CanMode))
def test_reception_follows_the_mode_alone(bench: Bench, mode: CanMode, format: FrameFormat) -> None:
    handle = bench.open()
    handle.can_mode = mode
    handle.frame_format = format
    bench.peer.send(Frame(0x10), Frame(0x10, extended=True))
    bench.run(0.01)
    formats = [event.fmt for event in events(handle) if event.event == RECEIVED]
    both = [FrameFormat.STD, FrameFormat.EXT]
    assert formats == (both if mode == CanMode.CAN_2_0_B else [FrameFormat.STD])


# A7, ruling 32


@pytest.mark.finding("candrv A7")
@pytest.mark.conforms("FS-57")
@pytest.mark.parametrize("how", ["command", "registry"])
def test_two_programs_on_one_board_alone(bench: Bench, registry: RegistryStore, how: str) -> None:
    """The driver hands messages on by itself, at once, though nobody acknowledges."""
    if how == "registry":
        registry.set("CID1", "Virtualize", 1)
    bench.absent_peer()
    sender, other = bench.open(), bench.open(hub=bench.program("second"))
    if how == "command":
        other.command(Command.VIRTUALIZE_ON)
    for number in range(5):
        sender.write(f"{number:x} 0 2 aa {number:x}\n")
    assert received(other) == [(number, bytes([0xAA, number])) for number in range(5)]
    assert received(sender) == []
    bench.run(0.01)
    assert received(other) == []
    bench.peer.start()
    bench.run(0.1)
    assert kinds(sender).count(TRANSMITTED) == 5
    assert received(other) == []
    assert [frame.id for frame in bench.peer.received(5)] == list(range(5))


@pytest.mark.finding("candrv A7")
@pytest.mark.conforms("FS-57", "FS-53")
def test_virtually_in_listen_only_mode_too(bench: Bench) -> None:
    sender, other = bench.open(), bench.open()
    assert bench.peer
    sender.command(Command.VIRTUALIZE_ON)
    sender.command(Command.LISTEN_ON)
    sender.write("12 0 f 1 2 3 4 5 6 7 8\n13 1 3\n")
    assert received(other) == [(0x12, bytes(range(1, 9))), (0x13, b"")]
    sender.command(Command.LISTEN_OFF)
    bench.run(0.01)
    assert [frame.id for frame in bench.peer.received(2)] == [0x12, 0x13]
    assert received(other) == []


# A8, ruling 33


@pytest.mark.finding("candrv A8")
@pytest.mark.conforms("FS-38")
def test_a_filter_may_ask_for_data_of_zeros(bench: Bench) -> None:
    """Fan 0 of chapter 3; and bytes that a frame does not have are not compared."""
    handle = bench.open()
    handle.filter = CAN_ACCEPTANCE_FILTER(0x200 << 21, 0x00FF)
    frames = [Frame(0x200, data) for data in (b"\0", b"\1", b"\0\xff", b"\xff\0", b"")]
    bench.peer.send(*frames, Frame(0x200, remote=True, dlc=2))
    bench.run(0.01)
    assert received(handle) == [(0x200, b"\0"), (0x200, b"\0\xff"), (0x200, b""), (0x200, b"")]


@pytest.mark.finding("candrv A8")
@pytest.mark.conforms("FS-38")
def test_a_registry_s_filter_means_any_data_unless_it_names_some(
    bench: Bench, registry: RegistryStore
) -> None:
    registry.set("CID1", "AcceptanceCode", 0x200 << 21)
    handle = bench.open(accept=False)
    bench.peer.send(Frame(0x200, b"\x11\x22"), Frame(0x200), Frame(0x201))
    bench.run(0.01)
    assert received(handle) == [(0x200, b"\x11\x22"), (0x200, b"")]
    handle.filter = handle.filter
    bench.peer.send(Frame(0x200, b"\x11\x22"), Frame(0x200), Frame(0x200, b"\0"))
    bench.run(0.01)
    assert received(handle) == [(0x200, b"\x11\x22"), (0x200, b""), (0x200, b"\0")]


# B1, ruling 34; B2


@pytest.mark.finding("candrv B1")
@pytest.mark.conforms("FS-45", "FS-46")
def test_a_format_leaves_the_controller_alone(bench: Bench) -> None:
    """Also amid traffic, by a program that only looks; everybody is told."""
    handle, query = bench.open(), bench.open(read=False, write=False, hub=bench.program("second"))
    handle.can_mode = CanMode.CAN_2_0_B
    assert bench.peer
    for number in range(60):
        handle.write(f"{number:x} 0 8 0 0 0 0 0 0 0 0\n")
        if number % 3 == 0:
            bench.run(0.00007)
            query.frame_format = (FrameFormat.EXT, FrameFormat.STD)[number % 2]
    bench.run(0.1)
    found = kinds(handle)
    assert (found.count(TRANSMITTED), found.count(ABORTED), found.count(CHANGED)) == (60, 0, 21)
    frames = bench.peer.received(60)
    assert [frame.id for frame in frames] == list(range(60))
    assert {frame.extended for frame in frames} == {True, False}


@pytest.mark.finding("candrv B2")
@pytest.mark.conforms("FS-56")
def test_loop_back_stays_until_init(bench: Bench) -> None:
    """A rate, a mode or a format must not let test messages out onto the live bus."""
    handle = bench.open()
    assert bench.peer
    handle.command(Command.SELF_RECEPTION_REQUEST)
    handle.can_mode = CanMode.CAN_2_0_B
    handle.frame_format = FrameFormat.STD
    handle.baud_rate = 1_000_000
    assert handle.device.state().loop_back
    handle.initialise()
    assert not handle.device.state().loop_back
    handle.command(Command.SELF_RECEPTION_REQUEST)
    handle.command(Command.LISTEN_OFF)
    assert not handle.device.state().loop_back


# B3: CAN2.0A is no BasicCAN


@pytest.mark.finding("candrv B3")
@pytest.mark.conforms("FS-50", "FS-51")
@pytest.mark.parametrize("mode", list(CanMode))
def test_all_commands_in_both_modes(bench: Bench, mode: CanMode) -> None:
    """The chip stays in PeliCAN mode, whose 128 registers answer in both."""
    handle = bench.open()
    handle.can_mode = mode
    properties = handle.properties()
    assert properties.nCommands == 9
    handle.command(Command.LISTEN_ON)
    assert handle.device.state().listen
    assert refusal(handle.command, 10) == Win32Error.ERROR_INVALID_PARAMETER


# B5, B6: an MCP2515's registers


@pytest.mark.finding("candrv B5")
@pytest.mark.conforms("FS-55")
def test_clear_overrun_clears_what_is_set(bench: Bench) -> None:
    """With the driver held up, so that it has not done so itself; the event comes all the same."""
    handle = bench.open()
    assert bench.peer
    bench.hub.hold_interrupts(bench.board, 0, True)
    bench.peer.send(*(Frame(number, bytes(8)) for number in range(1, 20)))
    bench.run(0.05)
    names = bench.registers()
    name, bits = ("SR", 0x02) if "SR" in names else ("EFLG", 0xC0)
    assert names[name] & bits
    handle.command(Command.CLEAR_OVERRUN)
    assert not bench.registers()[name] & bits
    bench.hub.hold_interrupts(bench.board, 0, False)
    bench.run(0.01)
    assert CanbusEvent.OVERRUN in kinds(handle)


@pytest.mark.finding("candrv B6")
@pytest.mark.conforms("FS-58")
def test_interrupts_off_and_on_again(bench: Bench, registry: RegistryStore) -> None:
    """By way of the registers; what came meanwhile is received, or told of as lost, and reception goes on."""
    handle = bench.open()
    enable, on = (4, 0xFF) if registry.get("CID1", "Board") == "inducan104" else (CANINTE, 0xFF)
    before = handle.read_register(enable)
    handle.write_register(enable, 0)
    bench.peer.send(Frame(1), Frame(2))
    bench.run(0.01)
    assert kinds(handle) == []
    handle.write_register(enable, before if enable == 4 else on)
    bench.run(0.01)
    assert received(handle) == [(1, b""), (2, b"")]
    bench.peer.send(Frame(3))
    bench.run(0.01)
    assert received(handle) == [(3, b"")]


def test_a_handle_says_what_became_of_its_messages(bench: Bench) -> None:
    handle = bench.open(read=False)
    bench.absent_peer()
    for number in range(5):
        handle.write(f"{number:x} 0 0\n")
    bench.run(0.01)
    assert handle.sending == (5, 0, 0)
    handle.abort()
    bench.run(0.01)
    assert handle.sending == (0, 0, 5)
    reader = bench.open(write=False)
    with pytest.raises(CandrvError, match="not open for writing"):
        reader.sending  # noqa: B018
    assert control(reader, candrv.ControlCode.TEST_DEVICE).answer == 0


# B11, B12, B14, B15: devices


@pytest.mark.finding("candrv B11", "candrv C5")
@pytest.mark.conforms("FS-08")
def test_each_board_has_an_spi_port_of_its_own(bench: Bench, registry: RegistryStore) -> None:
    registry.set("CID1", "Board", "picocom1")
    registry.set("CID1", "DirectInterface", 1)
    registry.install("CID2")
    registry.set("CID2", "Board", "inducan104")
    with bench.open(name="CID2:"), bench.open(name="CID1:") as handle:
        assert handle.device.settings.direct_interface
    for device in ("CID1:", "CID2:"):
        candrv.unload(bench.hub, device)
    registry.set("CID2", "Board", "picocom1")
    with bench.open(name="CID2:"):
        assert refusal(bench.open, name="CID1:") == Win32Error.ERROR_SHARING_VIOLATION


@pytest.mark.finding("candrv B12")
def test_a_driver_that_somebody_queries_is_not_restarted(bench: Bench) -> None:
    with bench.open(read=False, write=False), pytest.raises(InUse, match="to query it"):
        candrv.unload(bench.hub, "CID1:")
    candrv.unload(bench.hub, "CID1:")


@pytest.mark.finding("candrv B14")
def test_device_names_in_either_case(bench: Bench) -> None:
    with bench.open(name="cid1:") as lower, bench.open(name="Cid1:") as mixed:
        assert (lower.name, mixed.name) == ("CID1:", "CID1:")
    candrv.unload(bench.hub, "cid1:")
    assert candrv.active(bench.hub) == ()


@pytest.mark.finding("candrv B15")
def test_a_board_that_was_pulled_out_has_one_code(bench: Bench) -> None:
    handle = bench.open()
    bench.unplug()
    gone = Win32Error.ERROR_DEVICE_REMOVED
    assert refusal(handle.write, "1 0 0\n") == gone
    assert refusal(handle.read_event) == gone
    assert refusal(handle.initialise) == gone
    assert refusal(lambda: handle.baud_rate) == gone
    assert refusal(handle.device.change, rate=500_000) == gone
    assert refusal(handle.device.read_register, 0, reset_mode=False) == gone
    assert refusal(bench.open) == Win32Error.ERROR_FILE_NOT_FOUND


# B16: [HKLM\Drivers\Active]


@pytest.mark.finding("candrv B16")
def test_loaded_drivers(bench: Bench, registry: RegistryStore) -> None:
    registry.set("CID1", "Baudrate", 250_000)
    assert candrv.active(bench.hub) == ()
    with bench.open():
        [driver] = candrv.active(bench.program("another"))
        assert (driver.name, driver.is_open) == ("CID1:", True)
        assert driver.stored["Baudrate"] == 250_000
        assert driver.board is not None
        assert (driver.board.id, driver.line) == (bench.board, 0)
        assert driver.state is not None
        assert driver.state.rate == 250_000
    registry.set("CID1", "Baudrate", 500_000)  # counts for the next time
    [driver] = candrv.active(bench.hub)
    assert (driver.stored["Baudrate"], driver.is_open) == (250_000, False)
    bench.unplug()
    [driver] = candrv.active(bench.hub)
    assert (driver.board, driver.state) == (None, None)


# B7: reset mode amid traffic


@pytest.mark.finding("candrv B7")
@pytest.mark.conforms("FS-58")
def test_reset_mode_breaks_no_frame_of_its_own_off(bench: Bench) -> None:
    """It waits for the frame on the wire, so nothing arrives twice."""
    handle = bench.open()
    assert bench.peer
    for number in range(80):
        handle.write(f"{number:x} 0 8 0 0 0 0 0 0 0 0\n")
        bench.run(0.0001 + number * 0.5e-6)  # at last in the end of the frame, which the partner has by then
        handle.read_register(0x2A, reset_mode=True)
        bench.run(0.001)
    assert [frame.id for frame in bench.peer.received(80)] == list(range(80))
    assert bench.peer.receive(0) is None
    assert kinds(handle).count(TRANSMITTED) == 80


@pytest.mark.finding("socketcan 1")
def test_a_state_that_comes_as_soon_as_the_handle_hears_is_told(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    writer = bench.open()
    assert bench.peer
    activate = HubChannel.activate

    def go_bus_off(channel: HubChannel) -> LineStatus:
        monkeypatch.setattr(HubChannel, "activate", activate)
        began = activate(channel)
        bench.faults.flip(bit=20, times=32)  # 32 * 8 errors: bus-off
        writer.write("1 0 0\n")
        while bench.hub.line_status(bench.board, 0).state != ErrorState.BUS_OFF:
            bench.run(0.001)
        return began

    monkeypatch.setattr(HubChannel, "activate", go_bus_off)
    assert kinds(bench.open())[-3:] == [CanbusEvent.WARNING, CanbusEvent.PASSIVE, CanbusEvent.BUS_ERROR]
