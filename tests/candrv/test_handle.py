"""Handles in virtual time: channels, text, timeouts, events, transmission (FS-14..35, FS-45, FS-61..66)."""

from __future__ import annotations

from dataclasses import replace

import pytest

import canwire
from canwire import Frame, candrv
from canwire.candrv import Handle
from canwire.candrv.constants import CanbusEvent, CanMode, Command, ControlCode, FrameFormat, Win32Error
from canwire.candrv.errors import CandrvError
from canwire.candrv.event_queue import Event
from canwire.candrv.handle.writing import PartialWrite
from canwire.candrv.ioctl import control
from canwire.candrv.registry.registry import RegistryStore
from canwire.candrv.structures import CAN_ACCEPTANCE_FILTER
from tests.candrv.bench import Bench

RECEIVED, TRANSMITTED, ABORTED = CanbusEvent.RECEIVED, CanbusEvent.TRANSMITTED, CanbusEvent.ABORTED
FRAME_NS = 111_000  # about, at 1 Mbit/s with eight bytes


def events(handle: Handle) -> list[Event]:
    """Everything that waits now."""
    return [handle.read_event() for _ in range(handle.waiting)]


def kinds(handle: Handle) -> list[int]:
    return [event.event for event in events(handle)]


def read_timeout(handle: Handle, milliseconds: int) -> None:
    timeouts = handle.timeouts
    timeouts.ReadTotalTimeoutConstant = milliseconds
    handle.timeouts = timeouts


def write_timeout(handle: Handle, constant: int, multiplier: int = 0) -> None:
    timeouts = handle.timeouts
    timeouts.WriteTotalTimeoutConstant, timeouts.WriteTotalTimeoutMultiplier = constant, multiplier
    handle.timeouts = timeouts


def command(handle: Handle, number: int) -> None:
    control(handle, ControlCode.SET_COMMAND, number.to_bytes(4, "little"))


def refusal(call: object, *args: object, **kwargs: object) -> int:
    with pytest.raises(CandrvError) as raised:
        call(*args, **kwargs)  # type: ignore[operator]
    return raised.value.code


# opening


@pytest.mark.conforms("FS-14")
def test_query_handle_sets_but_neither_reads_nor_writes(bench: Bench) -> None:
    handle = bench.open(read=False, write=False)
    control(handle, ControlCode.SET_BAUDRATE, (500_000).to_bytes(4, "little"))
    assert control(handle, ControlCode.GET_BAUDRATE, b"", 4).data == (500_000).to_bytes(4, "little")
    assert refusal(handle.read_event) == Win32Error.ERROR_ACCESS_DENIED
    assert refusal(handle.write, "1 0 0\n") == Win32Error.ERROR_ACCESS_DENIED


@pytest.mark.conforms("FS-15")
def test_a_missing_access_makes_the_wrong_call_fail(bench: Bench) -> None:
    reader, writer = bench.open(write=False), bench.open(read=False)
    for call in (reader.write, reader.abort):
        assert refusal(call, *(["1 0 0\n"] if call == reader.write else [])) == Win32Error.ERROR_ACCESS_DENIED
    for call in (writer.read_event, writer.read_text, writer.wait_comm_event):
        assert refusal(call) == Win32Error.ERROR_ACCESS_DENIED


@pytest.mark.conforms("FS-16")
def test_virtual_channels_run_out_and_come_back(bench: Bench) -> None:
    if bench.hub.board("picocom1").id != bench.board:
        pytest.skip("that board has any number of channels")
    readers = [bench.open(write=False) for _ in range(2)]
    writers = [bench.open(read=False) for _ in range(3)]
    bench.open(read=False, write=False)
    for access in ({"write": False}, {"read": False}, {}):
        assert refusal(bench.open, **access) == Win32Error.ERROR_NO_SYSTEM_RESOURCES
    readers[0].close()
    bench.open(write=False)
    assert refusal(bench.open) == Win32Error.ERROR_NO_SYSTEM_RESOURCES
    writers[1].close()
    bench.open(read=False)
    assert refusal(bench.open, read=False) == Win32Error.ERROR_NO_SYSTEM_RESOURCES


@pytest.mark.conforms("FS-17")
@pytest.mark.parametrize(
    ("share", "read", "write", "allowed"),
    [
        (1, True, False, True),
        (1, False, True, False),
        (1, True, True, False),
        (2, False, True, True),
        (2, True, False, False),
        (0, True, False, False),
        (0, False, True, False),
        (0, False, False, True),
        (3, True, True, True),
    ],
)
def test_share_modes(bench: Bench, share: int, read: bool, write: bool, allowed: bool) -> None:
    first = bench.open(read=share != 2, write=share == 2, share=share)
    if allowed:
        bench.open(read=read, write=write)
    else:
        assert refusal(bench.open, read=read, write=write) == Win32Error.ERROR_SHARING_VIOLATION
    first.close()
    bench.open(read=read, write=write)


@pytest.mark.conforms("FS-18")
def test_traffic_flows_without_init(bench: Bench, registry: RegistryStore) -> None:
    registry.set("CID1", "Baudrate", 500_000)
    handle = bench.open()
    assert handle.device.state().rate == 500_000
    assert handle.device.status().running


def test_settings_act_when_the_driver_is_loaded_again(bench: Bench, registry: RegistryStore) -> None:
    bench.open().close()
    registry.set("CID1", "Baudrate", 250_000)
    handle = bench.open()
    assert handle.device.state().rate == 1_000_000
    handle.close()
    candrv.unload(bench.hub, "CID1:")
    assert bench.open().device.state().rate == 250_000


def test_a_rate_set_by_one_handle_stays_for_the_next(bench: Bench) -> None:
    with bench.open(read=False, write=False) as handle:
        handle.device.change(rate=125_000)
    assert bench.open().device.state().rate == 125_000


@pytest.mark.conforms("FS-19")
def test_a_new_receive_channel_starts_with_the_stored_filter(bench: Bench, registry: RegistryStore) -> None:
    registry.set("CID1", "AcceptanceCode", 0x2400_0000)
    registry.set("CID1", "AcceptanceMask", 0x00E0_0000)
    handle = bench.open(accept=False)
    assert handle.filter == CAN_ACCEPTANCE_FILTER(0x2400_0000, 0x00E0_0000)
    assert handle.mask == 0x7FF
    bench.peer.send(Frame(0x11F), Frame(0x120), Frame(0x127), Frame(0x128))
    bench.run(0.01)
    assert [event.identifier for event in events(handle)] == [0x120, 0x127]


@pytest.mark.conforms("FS-19")
def test_the_default_filter_accepts_identifier_0_only(bench: Bench) -> None:
    handle = bench.open(accept=False)
    bench.peer.send(Frame(1), Frame(0), Frame(0x7FF))
    bench.run(0.01)
    assert [event.identifier for event in events(handle)] == [0]


def test_unknown_device(bench: Bench) -> None:
    with pytest.raises(CandrvError, match="CID7:") as raised:
        candrv.open("CID7:", hub=bench.hub)
    assert raised.value.code == Win32Error.ERROR_FILE_NOT_FOUND


def test_a_closed_handle_says_so(bench: Bench) -> None:
    handle = bench.open()
    handle.close()
    handle.close()
    assert refusal(handle.read_event) == Win32Error.ERROR_INVALID_HANDLE
    assert refusal(handle.write, "1 0 0\n") == Win32Error.ERROR_INVALID_HANDLE
    assert refusal(lambda: handle.mask) == Win32Error.ERROR_INVALID_HANDLE
    assert refusal(lambda: handle.timeouts) == Win32Error.ERROR_INVALID_HANDLE


# text out


@pytest.mark.conforms("FS-23")
def test_example_1_of_write_file(bench: Bench) -> None:
    handle = bench.open()
    assert handle.write("731 0 4 11 22 33 44\n") == 20
    assert bench.peer.receive(1) == Frame(0x731, b"\x11\x22\x33\x44")


@pytest.mark.conforms("FS-24")
def test_several_messages_in_one_call_and_one_in_several(bench: Bench) -> None:
    handle = bench.open()
    bench.peer.receive(0)
    handle.write("1 0 1 11 22 33\r\n2 0 0\0")
    for piece in ("3 ", "0 1", " AA", "\n"):
        handle.write(piece)
    assert bench.peer.received(3) == [Frame(1, b"\x11"), Frame(2), Frame(3, b"\xaa")]


@pytest.mark.conforms("FS-25")
def test_malformed_text_reaches_no_bus(bench: Bench) -> None:
    handle = bench.open()
    bench.peer.receive(0)
    with pytest.raises(PartialWrite) as raised:
        handle.write("1 0 0\n2 5 0\n3 0 0\n")
    assert raised.value.code == Win32Error.ERROR_INVALID_PARAMETER
    assert raised.value.written == 8
    handle.write("4 0 0\n")
    assert bench.peer.received(2) == [Frame(1), Frame(4)]
    assert bench.peer.receive(0.01) is None


@pytest.mark.conforms("FS-25")
def test_an_identifier_that_does_not_fit_is_refused(bench: Bench) -> None:
    handle = bench.open()
    with pytest.raises(PartialWrite, match=r"bits 10\.\.0") as raised:
        handle.write("1 0 0\n800 0 0\n")
    assert (raised.value.code, raised.value.written) == (Win32Error.ERROR_INVALID_PARAMETER, 6)


def test_dlc_above_8_is_transferred_as_set(bench: Bench) -> None:
    handle = bench.open()
    handle.write("1 0 f 1 2 3 4 5 6 7 8\n")
    frame = bench.peer.receive(1)
    assert frame is not None
    assert (frame.dlc, frame.data) == (15, bytes(range(1, 9)))
    assert handle.read_text().endswith(b"15\r\n\t01\t02\t03\t04\t05\t06\t07\t08\n")


def test_remote_frames(bench: Bench) -> None:
    handle = bench.open()
    handle.write("12 1 3\n")
    assert bench.peer.receive(1) == Frame(0x12, remote=True, dlc=3)
    bench.peer.send(Frame(0x13, remote=True, dlc=2))
    handle.read_event()
    assert handle.read_text().endswith(b"\t00000013\t1\t2\r\n\t0\n")


# text in


@pytest.mark.conforms("FS-26")
def test_read_file_gives_one_event_as_text(bench: Bench) -> None:
    handle = bench.open()
    bench.run(1)
    bench.peer.send(Frame(0x112, b"\x01\xab"))
    assert handle.read_text() == b"received\t0:1000\t00000112\t0\t2\r\n\t01\tab\t0\n"


@pytest.mark.conforms("FS-28")
def test_an_event_is_never_truncated(bench: Bench) -> None:
    handle = bench.open()
    bench.peer.send(Frame(0x112, b"\x01\xab"))
    bench.run(0.01)
    assert refusal(handle.read_text, 10) == Win32Error.ERROR_INSUFFICIENT_BUFFER
    assert handle.read_text(100).startswith(b"received\t")


@pytest.mark.conforms("FS-29")
def test_read_timeout(bench: Bench) -> None:
    handle = bench.open()
    for milliseconds in (0, 1, 250):
        read_timeout(handle, milliseconds)
        began_ns = bench.hub.now_ns()
        assert refusal(handle.read_event) == Win32Error.ERROR_TIMEOUT
        assert abs((bench.hub.now_ns() - began_ns) / 1e6 - milliseconds) <= 1


def test_iterating_ends_with_the_read_timeout(bench: Bench) -> None:
    handle = bench.open()
    read_timeout(handle, 10)
    bench.peer.send(Frame(1), Frame(2))
    assert [event.identifier for event in handle] == [1, 2]


@pytest.mark.conforms("FS-31")
def test_each_handle_keeps_its_own_timeouts(bench: Bench) -> None:
    first, second = bench.open(), bench.open()
    timeouts = first.timeouts
    timeouts.ReadIntervalTimeout, timeouts.ReadTotalTimeoutMultiplier = 5, 1000
    timeouts.ReadTotalTimeoutConstant = 3
    first.timeouts = timeouts
    timeouts.ReadTotalTimeoutConstant = 9
    assert first.timeouts.ReadTotalTimeoutConstant == 3
    assert (first.timeouts.ReadIntervalTimeout, first.timeouts.ReadTotalTimeoutMultiplier) == (5, 1000)
    assert second.timeouts.ReadTotalTimeoutConstant == 0xFFFF_FFFF
    began_ns = bench.hub.now_ns()
    assert refusal(first.read_event) == Win32Error.ERROR_TIMEOUT
    assert bench.hub.now_ns() - began_ns <= 4_000_000


def test_a_timeouts_copy_changes_nothing(bench: Bench) -> None:
    handle = bench.open()
    handle.timeouts.ReadTotalTimeoutConstant = 1
    assert handle.timeouts.ReadTotalTimeoutConstant == 0xFFFF_FFFF


# masks, queues


@pytest.mark.conforms("FS-32", "FS-33")
def test_the_mask_records_and_deletes(bench: Bench) -> None:
    handle, other = bench.open(), bench.open()
    handle.write("1 0 0\n")
    bench.peer.send(Frame(2))
    bench.run(0.01)
    handle.mask = RECEIVED
    handle.mask = 0x7FF
    assert kinds(handle) == [RECEIVED]
    assert kinds(other) == [RECEIVED]
    handle.mask = TRANSMITTED
    assert handle.mask == TRANSMITTED
    bench.peer.send(Frame(3))
    handle.write("1 0 0\n")
    bench.run(0.01)
    assert kinds(handle) == [TRANSMITTED]
    assert kinds(other) == [RECEIVED]


@pytest.mark.conforms("FS-35")
def test_a_full_queue_counts_what_it_loses(bench: Bench, registry: RegistryStore) -> None:
    registry.set("CID1", "EventQueueSize", 3)
    handle = bench.open()
    bench.peer.send(*(Frame(n) for n in range(1, 8)))
    bench.run(0.01)
    assert [(event.identifier, event.lost) for event in events(handle)] == [(1, 0), (2, 0), (3, 0)]
    bench.peer.send(Frame(8), Frame(9))
    bench.run(0.01)
    assert [(event.identifier, event.lost) for event in events(handle)] == [(8, 4), (9, 0)]


@pytest.mark.conforms("FS-35")
def test_what_the_hub_had_no_room_for_is_counted_too(bench: Bench) -> None:
    handle = bench.open()
    for _ in range(10):
        bench.peer.send(*(Frame(n % 0x700) for n in range(500)))
        bench.run(0.2)
    assert len(events(handle)) == 200
    bench.peer.send(Frame(0x7FF))
    assert handle.read_event().lost == 4800


@pytest.mark.conforms("FS-36")
def test_wait_comm_event_leaves_the_event(bench: Bench) -> None:
    handle = bench.open()
    read_timeout(handle, 0)
    bench.peer.send(Frame(5))
    assert handle.wait_comm_event() == RECEIVED
    assert handle.wait_comm_event() == RECEIVED
    assert handle.read_event().identifier == 5
    assert refusal(handle.wait_comm_event, 0.01) == Win32Error.ERROR_TIMEOUT


# transmission


@pytest.mark.conforms("FS-62")
def test_one_transmitted_event_for_each_message_with_its_time(bench: Bench) -> None:
    handle, other = bench.open(), bench.open()
    bench.peer.receive(0)
    bench.run(2)
    handle.write("100 0 2 aa bb\n101 0 0\n")
    bench.run(0.01)
    found = events(handle)
    assert [(event.event, event.identifier, event.data) for event in found] == [
        (TRANSMITTED, 0x100, b"\xaa\xbb"),
        (TRANSMITTED, 0x101, b""),
    ]
    assert [event.time for event in found] == [2000, 2000]
    assert kinds(other) == []


@pytest.mark.conforms("FS-62")
@pytest.mark.parametrize("mode", [0, 1, 4, 5])
def test_no_transmitted_events_without_bit_1(bench: Bench, registry: RegistryStore, mode: int) -> None:
    registry.set("CID1", "TxMode", mode)
    handle = bench.open()
    bench.peer.receive(0)
    handle.write("1 0 0\n")
    bench.run(0.01)
    assert kinds(handle) == []


@pytest.mark.conforms("N-55")
def test_what_keeps_an_adapter_off_its_bus_stands_in_the_error(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    handle = bench.open()
    bench.absent_peer()
    write_timeout(handle, 20, 10)
    told = canwire.Hub.line_status
    monkeypatch.setattr(
        canwire.Hub,
        "line_status",
        lambda *where, **kin: replace(told(*where, **kin), obstacle="can0: no such adapter"),
    )
    with pytest.raises(CandrvError, match=r"send buffer full, \d+ messages wait: can0: no such adapter"):
        handle.write("1 0 2 1 2\n" * 200)


@pytest.mark.conforms("FS-61", "FS-30")
def test_send_buffer_mode_blocks_only_when_full(bench: Bench) -> None:
    handle = bench.open()
    bench.absent_peer()
    write_timeout(handle, 20, 10)
    began_ns = bench.hub.now_ns()
    for _ in range(100):
        handle.write("1 0 2 1 2\n")
    assert bench.hub.now_ns() - began_ns < 1_000_000
    bench.run(0)
    handle.write("1 0 2 1 2\n")  # the controller has taken one
    began_ns = bench.hub.now_ns()
    assert refusal(handle.write, "1 0 2 1 2\n") == Win32Error.ERROR_TIMEOUT
    assert abs((bench.hub.now_ns() - began_ns) / 1e6 - 40) <= 1  # 10 * 2 + 20
    bench.peer.start()
    handle.write("2 0 0\n")
    assert len(bench.peer.received(102)) == 102


@pytest.mark.conforms("FS-61", "FS-30")
@pytest.mark.parametrize("mode", [4, 6])
def test_single_message_mode_returns_when_the_message_is_sent(
    bench: Bench, registry: RegistryStore, mode: int
) -> None:
    registry.set("CID1", "TxMode", mode)
    handle = bench.open()
    assert bench.peer
    bench.run(0.001)
    began_ns = bench.hub.now_ns()
    handle.write("1 0 8 1 2 3 4 5 6 7 8\n")
    assert FRAME_NS <= bench.hub.now_ns() - began_ns < 2 * FRAME_NS
    assert bench.peer.receive(0) is not None


@pytest.mark.conforms("FS-30")
def test_single_message_mode_times_out_and_sends_nothing_later(bench: Bench, registry: RegistryStore) -> None:
    registry.set("CID1", "TxMode", 6)
    handle = bench.open()
    peer = bench.absent_peer()
    write_timeout(handle, 5, 5)
    began_ns = bench.hub.now_ns()
    assert refusal(handle.write, "1 0 2 1 2\n") == Win32Error.ERROR_TIMEOUT
    assert 15 <= (bench.hub.now_ns() - began_ns) / 1e6 <= 36
    assert ABORTED in kinds(handle)
    peer.start()
    handle.write("2 0 0\n")
    assert peer.receive(1) == Frame(2)


@pytest.mark.conforms("FS-63")
def test_what_counts_as_sent(bench: Bench, registry: RegistryStore) -> None:
    """The two moments are a frame apart."""
    times = {}
    for mode in (3, 7):
        registry.set("CID1", "TxMode", mode)
        handle = bench.open()
        assert bench.peer
        handle.device.change(rate=10_000)  # a frame takes 11 ms: the CAN time shows it
        bench.peer.stop()
        bench.run(1)
        handle.write("1 0 8 1 2 3 4 5 6 7 8\n")
        times[mode] = bench.hub.now_ns() // 1_000_000
        bench.run(0.001)
        found = [event.event for event in events(handle)]
        assert (TRANSMITTED in found) == (mode == 3)
        handle.close()
        candrv.unload(bench.hub, "CID1:")


@pytest.mark.conforms("FS-63")
def test_single_message_mode_may_return_when_the_controller_has_it(
    bench: Bench, registry: RegistryStore
) -> None:
    registry.set("CID1", "TxMode", 2)
    handle = bench.open()
    bench.absent_peer()
    began_ns = bench.hub.now_ns()
    handle.write("1 0 0\n")
    assert bench.hub.now_ns() - began_ns < 20_000
    assert [event for event in kinds(handle) if event == TRANSMITTED] == [TRANSMITTED]
    write_timeout(handle, 5)
    assert refusal(handle.write, "2 0 0\n") == Win32Error.ERROR_TIMEOUT


@pytest.mark.conforms("FS-64")
def test_order_within_a_channel_and_arbitration_between_them(bench: Bench) -> None:
    high, low = bench.open(), bench.open()
    peer = bench.absent_peer()
    for n in range(5):
        low.write(f"{0x600 - n:x} 0 0\n")
    for n in range(5):
        high.write(f"{0x100 + n:x} 0 0\n")
    peer.start()
    frames = peer.received(10)
    assert [frame.id for frame in frames if frame.id >= 0x500] == [0x600, 0x5FF, 0x5FE, 0x5FD, 0x5FC]
    assert [frame.id for frame in frames if frame.id < 0x500] == [0x100, 0x101, 0x102, 0x103, 0x104]


@pytest.mark.conforms("FS-54")
def test_abort_purges_and_tells_of_every_message(bench: Bench) -> None:
    handle, other = bench.open(), bench.open()
    peer = bench.absent_peer()
    other.write("77 0 0\n")
    for n in range(10):
        handle.write(f"{n:x} 0 1 {n:x}\n")
    bench.run(0)
    command(handle, Command.ABORT_TRANSMISSION)
    peer.start()
    assert peer.receive(1) == Frame(0x77)
    bench.run(0.05)
    found = [event for event in events(handle) if event.has_message]
    aborted = [event.identifier for event in found if event.event == ABORTED]
    sent = [event.identifier for event in found if event.event == TRANSMITTED]
    assert sorted(aborted + sent) == list(range(10))
    assert len(sent) <= 1
    assert aborted == sorted(aborted)
    assert kinds(other).count(TRANSMITTED) == 1


@pytest.mark.conforms("FS-57")
@pytest.mark.parametrize("mode", [3, 7])
def test_virtualize(bench: Bench, registry: RegistryStore, mode: int) -> None:
    registry.set("CID1", "TxMode", mode)
    sender, writer = bench.open(), bench.open(read=False)
    other = bench.open(hub=bench.program("second"))
    assert bench.peer
    sender.write("10 0 1 1\n")
    bench.run(0.01)
    assert (kinds(sender), kinds(other)) == ([TRANSMITTED], [])
    command(other, Command.VIRTUALIZE_ON)
    sender.write("11 0 1 1\n")
    writer.write("12 0 0\n")
    bench.run(0.01)
    assert sorted(kinds(sender)) == [RECEIVED, TRANSMITTED]
    found = events(other)
    assert {(event.event, event.identifier) for event in found} == {(RECEIVED, 0x11), (RECEIVED, 0x12)}
    assert len(found) == 2
    command(sender, Command.VIRTUALIZE_OFF)
    sender.write("13 0 1 1\n")
    bench.run(0.01)
    assert (kinds(sender), kinds(other)) == ([TRANSMITTED], [])
    assert sorted(frame.id for frame in bench.peer.received(4)) == [0x10, 0x11, 0x12, 0x13]


@pytest.mark.conforms("FS-57")
def test_virtualize_passes_the_filters(bench: Bench, registry: RegistryStore) -> None:
    registry.set("CID1", "Virtualize", 1)
    sender, picky = bench.open(read=False), bench.open(accept=False)
    assert bench.peer
    sender.write("0 0 0\n1 0 0\n")
    bench.run(0.01)
    assert [(event.event, event.identifier) for event in events(picky)] == [(RECEIVED, 0)]


# events of the bus


@pytest.mark.conforms("FS-66")
def test_warning_passive_and_bus_error_once_each(bench: Bench) -> None:
    handle = bench.open()
    assert bench.peer
    bench.faults.flip(bit=20, times=32)  # 32 * 8 errors: bus-off
    handle.write("1 0 0\n")
    bench.run(0.2)
    steps = (CanbusEvent.WARNING, CanbusEvent.PASSIVE, CanbusEvent.BUS_ERROR)
    assert [event for event in kinds(handle) if event in steps] == list(steps)


@pytest.mark.conforms("FS-66")
def test_without_partner_it_stops_at_passive(bench: Bench) -> None:
    handle = bench.open()
    bench.absent_peer()
    handle.write("1 0 0\n")
    bench.run(0.2)
    assert kinds(handle) == [CanbusEvent.WARNING, CanbusEvent.PASSIVE]
    bench.peer.start()
    bench.run(0.2)
    assert kinds(handle) == [TRANSMITTED]


@pytest.mark.conforms("FS-65", "FS-55")
def test_overrun(bench: Bench) -> None:
    handle = bench.open()
    board = bench.board
    assert bench.peer
    bench.hub.hold_interrupts(board, 0, True)
    bench.peer.send(*(Frame(n, bytes(8)) for n in range(1, 20)))
    bench.run(0.05)
    bench.hub.hold_interrupts(board, 0, False)
    bench.run(0.01)
    found = events(handle)
    assert CanbusEvent.OVERRUN in [event.event for event in found]
    assert len([event for event in found if event.event == RECEIVED]) < 19
    command(handle, Command.CLEAR_OVERRUN)
    registers = bench.registers()
    assert not registers.get("SR", 0) & 0x02
    assert not registers.get("EFLG", 0) & 0xC0


def test_arbitration_lost(bench: Bench) -> None:
    handle = bench.open()
    peer = bench.absent_peer()
    handle.write("700 0 0\n")
    peer.send(Frame(0x100))
    peer.start()
    bench.run(0.05)
    assert CanbusEvent.ARBITRATION_LOST in kinds(handle)


# streams


def test_a_handle_is_a_text_stream(bench: Bench) -> None:
    handle = bench.open()
    print("731 0 2", "11 22", file=handle)
    assert bench.peer.receive(1) == Frame(0x731, b"\x11\x22")
    with handle.stream() as stream:
        print("732 0 0", file=stream, flush=True)
        bench.run(0.01)
        lines = [stream.readline() for _ in range(2)]
        assert lines[0].split() == ["transmitted", lines[0].split()[1], "00000731", "0", "2", "11", "22"]
        read_timeout(handle, 1)
        bench.peer.send(Frame(5), Frame(6))
        assert [line.split()[2] for line in stream] == ["00000005", "00000006"]
    assert handle.closed


@pytest.mark.conforms("FS-22")
def test_closing_sends_what_is_left(bench: Bench) -> None:
    handle = bench.open(read=False)
    assert bench.peer
    for n in range(100):
        handle.write(f"{n:x} 0 0\n")
    handle.close()
    assert [frame.id for frame in bench.peer.received(100)] == list(range(100))


@pytest.mark.conforms("FS-22")
@pytest.mark.parametrize("read", [False, True])
def test_closing_gives_up_where_nothing_moves(bench: Bench, read: bool) -> None:
    handle = bench.open(read=read)
    peer = bench.absent_peer()
    for n in range(50):
        handle.write(f"{n:x} 0 0\n")
    began_ns = bench.hub.now_ns()
    handle.close()
    assert bench.hub.now_ns() - began_ns < 1e9
    peer.start()
    bench.run(0.1)
    left = []
    while (frame := peer.receive(0)) is not None:
        left.append(frame)
    assert len(left) <= 1  # one was on the wire
    assert bench.hub.line_status(handle.device.board.id, 0).channels == 0


# what the device is asked and told in Python's way


def test_properties_of_python(bench: Bench) -> None:
    handle = bench.open()
    handle.baud_rate = 250_000
    handle.can_mode = CanMode.CAN_2_0_B
    handle.frame_format = FrameFormat.STD
    assert (handle.baud_rate, handle.can_mode, handle.frame_format) == (250_000, 1, 1)
    with pytest.raises(CandrvError, match="1234567") as raised:
        handle.baud_rate = 1_234_567
    assert raised.value.code == Win32Error.ERROR_INVALID_PARAMETER
    assert handle.baud_rate == 250_000
    assert handle.properties().max == 1_000_000
    handle.command(Command.VIRTUALIZE_ON)
    assert handle.virtualize
    handle.initialise()
    assert not handle.in_configuration_mode()
    bench.run(1)
    assert handle.time() == 1000
    handle.write_register(0x2A, 0x01, reset_mode=True)
    assert isinstance(handle.read_register(0x2A), int)
    handle.close()
    with pytest.raises(CandrvError) as raised:
        handle.baud_rate = 500_000
    assert raised.value.code == Win32Error.ERROR_INVALID_HANDLE


@pytest.mark.conforms("FS-06")
@pytest.mark.parametrize("debug", [0, 1])
def test_debug_prints_to_stderr(
    bench: Bench, registry: RegistryStore, capsys: pytest.CaptureFixture[str], debug: int
) -> None:
    registry.set("CID1", "Debug", debug)
    bench.open(read=False).close()
    assert ("CID1: opened" in capsys.readouterr().err) == bool(debug)


@pytest.mark.conforms("FS-02")
def test_two_devices_on_one_bus(bench: Bench, registry: RegistryStore) -> None:
    kind = registry.get("CID1", "Board")
    registry.install("CID2")
    registry.set("CID2", "Board", "picocom1" if kind == "inducan104" else "inducan104")
    first, second = bench.open(), bench.open(name="CID2:")
    first.write("11 0 0\n")
    second.write("12 0 0\n")
    bench.run(0.01)
    for handle in (first, second):
        messages = [event for event in events(handle) if event.has_message]
        assert sorted(event.identifier for event in messages) == [0x11, 0x12]
    assert (first.name, second.name) == ("CID1:", "CID2:")


def test_unload_waits_for_nobody(bench: Bench) -> None:
    handle = bench.open()
    with pytest.raises(canwire.InUse, match="CID1:"):
        candrv.unload(bench.hub, "CID1:")
    handle.close()
    candrv.unload(bench.hub, "CID1:")
    assert not bench.hub.line_status(bench.board, 0).initialised


def test_no_such_port(bench: Bench, registry: RegistryStore) -> None:
    registry.set("CID1", "DeviceArrayIndex", 1)
    with pytest.raises(CandrvError, match="CAN port 1") as raised:
        bench.open()
    assert raised.value.code == Win32Error.ERROR_FILE_NOT_FOUND


@pytest.mark.conforms("FS-30")
@pytest.mark.parametrize(("mode", "sent"), [(0, True), (4, False), (1, True), (5, True)])
def test_without_any_time(bench: Bench, registry: RegistryStore, mode: int, sent: bool) -> None:
    """In single message mode a message that counts once it is on the wire cannot be sent in no time."""
    registry.set("CID1", "TxMode", mode)
    handle = bench.open()
    assert bench.peer
    write_timeout(handle, 0)
    if sent:
        handle.write("1 0 0\n")
    else:
        assert refusal(handle.write, "1 0 0\n") == Win32Error.ERROR_TIMEOUT
    bench.run(0.01)
    assert (bench.peer.receive(0) is not None) == sent


def test_a_message_whose_time_ran_out_is_written_again(bench: Bench) -> None:
    handle = bench.open(read=False)
    peer = bench.absent_peer()
    write_timeout(handle, 1)
    text = "".join(f"{n:x} 0 0\n" for n in range(150))
    with pytest.raises(PartialWrite) as raised:
        handle.write(text)
    assert raised.value.code == Win32Error.ERROR_TIMEOUT
    peer.start()
    write_timeout(handle, 0xFFFF_FFFF)
    assert handle.write(text[raised.value.written :]) == len(text) - raised.value.written
    assert [frame.id for frame in peer.received(150)] == list(range(150))
