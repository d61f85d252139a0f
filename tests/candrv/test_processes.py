"""Programs that share CID1: (FS-15, FS-17, FS-46, FS-52, FS-57)."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

import canwire
from canwire import BitTiming, Frame, LineMode, candrv
from canwire.candrv import Handle
from canwire.candrv.constants import CanbusEvent, Command, ControlCode, Win32Error
from canwire.candrv.errors import CandrvError
from canwire.candrv.ioctl import control
from canwire.candrv.registry.registry import RegistryStore
from tests.candrv.bench import Peer

LONG = 30


@pytest.fixture
def second(connect: Callable[[str], canwire.Hub], hub: canwire.Hub) -> Iterator[Handle]:
    """Another program on the same machine."""
    with candrv.open(hub=connect("second program")) as made:
        made.accept_all()
        yield made


def command(handle: Handle, number: int) -> None:
    control(handle, ControlCode.SET_COMMAND, number.to_bytes(4, "little"))


def next_event(handle: Handle) -> int:
    timeouts = handle.timeouts
    timeouts.ReadTotalTimeoutConstant = LONG * 1000
    handle.timeouts = timeouts
    return handle.read_event().event


def test_messages_go_to_the_bus_not_to_each_other(handle: Handle, second: Handle, peer: Peer) -> None:
    handle.write("11 0 1 1\n")
    second.write("12 0 1 2\n")
    assert {frame.id for frame in peer.received(2)} == {0x11, 0x12}
    peer.send(Frame(0x13))
    for one in (handle, second):
        assert [next_event(one), next_event(one)] == [CanbusEvent.TRANSMITTED, CanbusEvent.RECEIVED]
        assert one.waiting == 0


@pytest.mark.conforms("FS-17")
def test_share_modes_hold_across_programs(hub: canwire.Hub, connect: Callable[[str], canwire.Hub]) -> None:
    other = connect("second program")
    with candrv.open(hub=hub, write=False, share=1):
        with pytest.raises(CandrvError, match="first program") as raised:
            candrv.open(hub=other)
        assert raised.value.code == Win32Error.ERROR_SHARING_VIOLATION
        candrv.open(hub=other, write=False).close()
    candrv.open(hub=other).close()


@pytest.mark.conforms("FS-46", "FS-42")
def test_a_change_is_told_to_every_program_and_holds_for_it(handle: Handle, second: Handle) -> None:
    control(second, ControlCode.SET_BAUDRATE, (250_000).to_bytes(4, "little"))
    for one in (handle, second):
        assert next_event(one) == CanbusEvent.DEVICE_CHANGED
        assert control(one, ControlCode.GET_BAUDRATE, b"", 4).data == (250_000).to_bytes(4, "little")


@pytest.mark.conforms("FS-44")
def test_a_mode_set_elsewhere_counts_at_once(handle: Handle, second: Handle, peer: Peer) -> None:
    control(second, ControlCode.SET_CAN_MODE, b"\1\0\0\0")
    handle.write("12 0 0\n")
    frame = peer.receive()
    assert (frame.id, frame.extended) == (0x12, True)


@pytest.mark.conforms("FS-57")
def test_virtualize_joins_programs(handle: Handle, second: Handle, peer: Peer) -> None:
    command(second, Command.VIRTUALIZE_ON)
    handle.write("11 0 1 1\n")
    assert next_event(second) == CanbusEvent.RECEIVED
    assert next_event(handle) == CanbusEvent.TRANSMITTED
    assert handle.waiting == 0
    command(handle, Command.VIRTUALIZE_OFF)
    second.write("12 0 1 1\n")
    assert next_event(second) == CanbusEvent.TRANSMITTED
    peer.received(2)
    assert handle.waiting == 0


@pytest.mark.conforms("FS-52")
def test_standby_is_everybodys(handle: Handle, second: Handle, peer: Peer) -> None:
    command(handle, Command.ENTER_STANDBY)
    assert next_event(second) == CanbusEvent.ENTERING_STANDBY
    peer.send(Frame(1))
    assert next_event(second) == CanbusEvent.LEAVING_STANDBY


def test_a_program_that_ends_gives_everything_back(
    hub: canwire.Hub, connect: Callable[[str], canwire.Hub]
) -> None:
    gone = connect("short-lived")
    candrv.open(hub=gone, share=0)
    with pytest.raises(CandrvError):
        candrv.open(hub=hub)
    gone.close()
    candrv.open(hub=hub).close()


def test_programs_that_configure_at_once_wait_for_each_other(handle: Handle, second: Handle) -> None:
    import threading

    errors: list[BaseException] = []

    def configure(one: Handle) -> None:
        try:
            for rate in (125_000, 250_000, 500_000) * 5:
                control(one, ControlCode.SET_BAUDRATE, rate.to_bytes(4, "little"))
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=configure, args=(one,)) for one in (handle, second)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(LONG)
    assert errors == []
    assert handle.device.state().rate == 500_000


def test_a_line_that_another_dialect_set_up_is_used_as_it_is(hub: canwire.Hub, peer: Peer) -> None:
    board = hub.board("HW000104").id
    timing = BitTiming.for_bit_rate(1_000_000, clock_hz=8_000_000)
    with hub.open_control(board, 0) as held:
        held.initialise(LineMode(timing))
        held.start()
        with candrv.open(hub=hub) as handle:
            handle.write("12 0 0\n")
            assert peer.receive() == Frame(0x12, extended=True)
            with pytest.raises(CandrvError) as raised:
                control(handle, ControlCode.SET_BAUDRATE, (500_000).to_bytes(4, "little"))
            assert raised.value.code == Win32Error.ERROR_SHARING_VIOLATION


def test_the_registry_is_read_once(
    registry: RegistryStore, hub: canwire.Hub, connect: Callable[[str], canwire.Hub]
) -> None:
    """All programs have the entries that the driver was loaded with."""
    registry.set("CID1", "SendBufferSize", 7)
    with candrv.open(hub=hub):
        registry.set("CID1", "SendBufferSize", 9)
        with candrv.open(hub=connect("second program")) as other:
            assert other.device.settings.send_buffer_size == 7
