"""ACAN.H's functions as a program calls them. Source: INduCAN104 manual, "Programming interface"."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from typing import Any

import pytest

import canwire
from canwire import Frame, NotInitialised, WrongState
from canwire.acan import api
from canwire.acan.constants import (
    BUS_OFF,
    BUS_ON,
    CANC_SJA1000,
    FF_EXTENDED,
    FF_RTR,
    IDA_CHANRCV,
    IDA_CHANSND,
    IDA_NOTIFY,
    IDA_QUEUEMSG,
    SC_BUSERR,
    TBNT_CALLBACK,
    TBNT_EVENT,
    TBNT_POSTMESSAGE,
    TBS_MB,
    TBS_OVERFLOW,
    TBS_SC,
)
from canwire.acan.structures import ACANHI, ACANID, ACANMB, ACANMBSZ, ACANTB
from tests.acan.bench import Peer, Virtual
from tests.descriptors import nothing_left_open

LONG = 30  # seconds after which something that should happen never will
USUAL = {"hi_clk": 16_000, "hi_rat": 250, "hi_ts1": 11, "hi_ts2": 5, "hi_sjw": 3, "hi_msi": 1}
ANY = ACANID(0, 0, IDA_NOTIFY | IDA_QUEUEMSG)


@pytest.fixture
def library(hub: canwire.Hub) -> Iterator[Any]:
    """The functions, after ACAN_Init."""
    api.use(hub)
    assert api.ACAN_Init() == 0x0100
    yield api
    api.use(None)


@pytest.fixture
def on_bus(library: Any) -> Any:
    assert library.ACAN_SetHardConfig(hardware())
    assert library.ACAN_BusControl(BUS_ON) == 0x0001
    return library


def hardware(**fields: Any) -> ACANHI:
    hi = ACANHI(**(USUAL | fields))
    hi.hi_ocr = 0x6A
    return hi


def block(**fields: Any) -> ACANTB:
    """A Task Block for every message, with an event, unless fields say otherwise."""
    usual: dict[str, Any] = {"lpRMB": [], "wRMBSize": 16, "lpBuf": [], "wCount": 16, "idTable": [ANY]}
    return ACANTB(**({"hEvent": threading.Event()} | usual | fields))


def told(fields: ACANTB) -> None:
    """Wait for its event, once."""
    assert fields.hEvent.wait(LONG)
    fields.hEvent.clear()


def taken(library: Any, fields: ACANTB, count: int) -> list[ACANMB]:
    """Messages as the manual recommends: acknowledge, retrieve until there are none, until there is no event."""
    found: list[ACANMB] = []
    while len(found) < count:
        told(fields)
        while library.ACAN_AckEventCheck(fields):
            while number := library.ACAN_RetrieveMessages(fields):
                found += fields.lpBuf[:number]
    return found


def raw(id: int, data: bytes = b"", **format: Any) -> ACANMB:
    return ACANMB(id << 18, 0, len(data), data)


@pytest.mark.conforms("AC-09", "AC-10")
def test_without_a_driver_everything_fails_quietly() -> None:
    api.ACAN_Exit()
    tb = block()
    answers = [
        api.ACAN_GetDriverVersion(),
        api.ACAN_GetInitStatus(),
        api.ACAN_SetHardConfig(hardware()),
        api.ACAN_GetHardConfig(ACANHI()),
        api.ACAN_BusControl(BUS_ON),
        api.ACAN_Register(tb),
        api.ACAN_AckEvent(tb),
        api.ACAN_AckEventCheck(tb),
        api.ACAN_Deregister(tb),
        api.ACAN_SendMessage(raw(1), 1),
        api.ACAN_RetrieveMessages(tb),
    ]
    assert answers == [0, 0, False, False, 0, False, 0, 0, False, False, -1]
    assert isinstance(api.last_error(), (NotInitialised, WrongState))


@pytest.mark.conforms("AC-09")
def test_init_answers_0_where_the_driver_is_uninstalled(hub: canwire.Hub) -> None:
    hub.set_note("acan", b"uninstalled")
    api.use(hub)
    assert api.ACAN_Init() == 0
    assert api.ACAN_GetDriverVersion() == 0
    hub.set_note("acan", b"")
    assert api.ACAN_Init() == 0x0100
    assert api.ACAN_Init() == 0x0100
    assert api.ACAN_GetDriverVersion() == 0x0100
    api.ACAN_Exit()
    assert api.ACAN_GetDriverVersion() == 0
    api.use(None)


@pytest.mark.conforms("AC-07", "AC-10", "AC-14", "AC-15", "AC-16")
def test_the_hardware_from_virgin_to_on_the_bus(library: Any) -> None:
    assert library.ACAN_GetInitStatus() == CANC_SJA1000
    assert not library.ACAN_GetHardConfig(ACANHI())
    assert library.ACAN_BusControl(BUS_ON) == 0x0000
    assert library.ACAN_SetHardConfig(hardware(hi_miv=3 << 18, hi_mim=7 << 18, hi_bim=7 << 18))
    assert library.ACAN_GetInitStatus() == 0x0100 | CANC_SJA1000
    assert library.ACAN_BusControl(BUS_OFF) == 0x0000
    assert library.ACAN_BusControl(BUS_ON) == 0x0001
    assert library.ACAN_BusControl(BUS_ON) == 0x0101
    assert library.ACAN_BusControl(BUS_OFF) == 0x0100
    assert library.ACAN_BusControl(BUS_ON) == 0x0001
    hi = ACANHI()
    assert library.ACAN_GetHardConfig(hi)
    assert hi == hardware(hi_miv=3 << 18, hi_mim=7 << 18, hi_bim=7 << 18)
    hi.hi_rat = 500
    assert library.ACAN_SetHardConfig(hi)
    assert library.ACAN_BusControl(BUS_ON) == 0x0001


def test_reserved_bytes_of_the_configuration_are_given_back_as_0(library: Any) -> None:
    given, hi = hardware(), ACANHI()
    given.hi_hsb = given.hi_hsb[:2] + bytes(range(1, 7))
    assert library.ACAN_SetHardConfig(given)
    library.ACAN_GetHardConfig(hi)
    assert hi.hi_hsb == given.hi_hsb[:2] + bytes(6)


@pytest.mark.conforms("AC-11")
@pytest.mark.parametrize(
    "fields", [{"hi_rat": 0}, {"hi_ts1": 1}, {"hi_ts1": 18}, {"hi_ts2": 0}, {"hi_ts2": 9}, {"hi_rat": 3}]
)
def test_hardware_fields_that_cannot_be_answer_false(library: Any, fields: dict[str, int]) -> None:
    assert library.ACAN_SetHardConfig(hardware(**fields)) is False
    assert "hi_" in str(library.last_error())
    assert library.ACAN_GetInitStatus() == 0


@pytest.mark.conforms("AC-17", "AC-25", "AC-26", "AC-29", "AC-30")
def test_messages_come_in_order_with_their_bits_aligned(on_bus: Any, peer: Peer) -> None:
    tb = block()
    assert on_bus.ACAN_Register(tb)
    peer.send(Frame(0x123, b"ab"), Frame(0x12345678, extended=True), Frame(0x7FF, remote=True, dlc=4))
    assert taken(on_bus, tb, 3) == [
        ACANMB(0x123 << 18, 0, 2, b"ab"),
        ACANMB(0x12345678, FF_EXTENDED, 0),
        ACANMB(0x7FF << 18, FF_RTR, 4),
    ]
    assert (tb.wStatus, tb.wRMBOccupation, tb.wRIndex, tb.wWIndex) == (0, 0, 3, 3)
    assert on_bus.ACAN_AckEvent(tb) == 0
    assert on_bus.ACAN_RetrieveMessages(tb) == 0


@pytest.mark.conforms("AC-29")
def test_a_full_fifo_shows_in_the_status_word(on_bus: Any, peer: Peer) -> None:
    small, done = block(wRMBSize=2, wCount=1), block(idTable=[ACANID(0x1FFFFFFF, 9 << 18, IDA_NOTIFY)])
    assert on_bus.ACAN_Register(small)
    assert on_bus.ACAN_Register(done)
    peer.send(Frame(1), Frame(2), Frame(3), Frame(9))
    told(done)
    assert small.wRMBOccupation == 2
    assert on_bus.ACAN_AckEvent(small) == TBS_MB | TBS_OVERFLOW
    assert [on_bus.ACAN_RetrieveMessages(small) for _ in range(3)] == [1, 1, 0]
    assert small.lpBuf == [raw(2)]


@pytest.mark.finding("acan A15.5")
def test_import_star_brings_the_manuals_functions_and_no_other_ones() -> None:
    found: dict[str, Any] = {}
    exec("from canwire.acan.api import *", found)
    functions = {name for name in dir(api) if name.startswith("ACAN_") and not name.isupper()}
    assert len(functions) == 15
    assert {name for name in found if name != "__builtins__" and not name.isupper()} == functions | {
        "last_error",
        "use",
    }


@pytest.mark.finding("acan A15.6")
def test_register_fills_the_event_in(on_bus: Any, peer: Peer) -> None:
    """As Win32's DLL does."""
    tb = block(hEvent=None)
    assert on_bus.ACAN_Register(tb)
    peer.send(Frame(1))
    assert tb.hEvent.wait(LONG)


def test_the_event_that_register_made_goes_with_its_block(on_bus: Any) -> None:
    """And not before: a block that is registered again has the same one."""
    with nothing_left_open():
        tb = block(hEvent=None)
        assert on_bus.ACAN_Register(tb)
        made = tb.hEvent
        assert on_bus.ACAN_Deregister(tb)
        assert on_bus.ACAN_Register(tb)
        assert tb.hEvent is made
        assert on_bus.ACAN_Deregister(tb)
        del tb, made


@pytest.mark.conforms("AC-25")
def test_notification_by_callback_with_the_block(on_bus: Any, peer: Peer) -> None:
    calls: queue.SimpleQueue[Any] = queue.SimpleQueue()
    tb = block(hEvent=None, bNotType=TBNT_EVENT, cbNotification=calls.put, dwRefData=5)
    assert on_bus.ACAN_Register(tb)
    peer.send(Frame(1))
    assert calls.get(timeout=LONG) is tb


@pytest.mark.conforms("AC-25")
def test_notification_by_callback_with_the_reference(on_bus: Any, peer: Peer) -> None:
    calls: queue.SimpleQueue[Any] = queue.SimpleQueue()
    tb = block(bNotType=TBNT_CALLBACK, cbNotification=calls.put, dwRefData=0x1234)
    assert on_bus.ACAN_Register(tb)
    peer.send(Frame(1))
    assert calls.get(timeout=LONG) == 0x1234


@pytest.mark.conforms("AC-25")
def test_notification_by_posted_message(on_bus: Any, peer: Peer) -> None:
    window: queue.SimpleQueue[Any] = queue.SimpleQueue()
    tb = block(bNotType=TBNT_POSTMESSAGE, hwnd=window, nMsg=0x400, dwRefData=7)
    assert on_bus.ACAN_Register(tb)
    peer.send(Frame(1))
    assert window.get(timeout=LONG) == (window, 0x400, TBS_MB, 7)


def test_a_virgin_controller_takes_messages_and_bus_on_gives_them_up(library: Any, peer: Peer) -> None:
    assert library.ACAN_SendMessage(raw(1), 255)
    assert library.ACAN_SetHardConfig(hardware())
    assert library.ACAN_BusControl(BUS_ON) == 0x0001
    assert library.ACAN_SendMessage(raw(2), 255)
    assert peer.receive() == Frame(2)


@pytest.mark.smoke
@pytest.mark.conforms("AC-31")
def test_messages_are_sent(on_bus: Any, peer: Peer) -> None:
    messages = [
        raw(0x123, b"abc"),
        ACANMB(0x1234567, FF_EXTENDED, 8, b"12345678"),
        ACANMB(0x7FF << 18, FF_RTR, 5),
    ]
    for message in messages:
        assert on_bus.ACAN_SendMessage(message, 255)
    assert peer.received(3) == [
        Frame(0x123, b"abc"),
        Frame(0x1234567, b"12345678", extended=True),
        Frame(0x7FF, remote=True, dlc=5),
    ]
    assert on_bus.ACAN_SendMessage(ACANMB(bLength=9), 1) is False
    assert on_bus.ACAN_SendMessage(raw(1), 256) is False


@pytest.mark.conforms("AC-31")
def test_sending_is_refused_when_no_buffer_is_left(library: Any) -> None:
    assert library.ACAN_SetHardConfig(hardware())
    assert any(not library.ACAN_SendMessage(raw(1), 1) for _ in range(10_000))
    assert isinstance(library.last_error(), canwire.QueueFull)


@pytest.mark.conforms("AC-32")
def test_priority_0_comes_back(on_bus: Any, peer: Peer) -> None:
    tb = block()
    assert on_bus.ACAN_Register(tb)
    assert on_bus.ACAN_SendMessage(raw(0x10), 1)
    assert on_bus.ACAN_SendMessage(raw(0x11), 0)
    assert taken(on_bus, tb, 1) == [raw(0x11)]
    assert sorted(frame.id for frame in peer.received(2)) == [0x10, 0x11]


@pytest.mark.conforms("AC-23", "AC-24")
def test_channels_work_in_an_applications_memory(on_bus: Any, peer: Peer) -> None:
    memory = on_bus.ACAN_AllocFixedMemory(8)
    receiving = ACANID(0x1FFFFFFF, 0x20 << 18, IDA_NOTIFY | IDA_CHANRCV, 4, lpAddress=memory)
    sending = ACANID(0x1FFFFFFF, 0x21 << 18, IDA_CHANSND, 8, lpAddress=memory)
    tb = block(idTable=[receiving, sending])
    assert on_bus.ACAN_Register(tb)
    peer.send(Frame(0x20, b"12345678"), Frame(0x21, raw(0x300).pack()[:5] + b"\x08"))
    assert peer.receive() == Frame(0x300, b"1234\0\0\0\0")
    told(tb)
    assert memory == b"1234\0\0\0\0"
    assert on_bus.ACAN_AckEvent(tb) == 0  # nothing was buffered: the notification was about the channel


@pytest.mark.conforms("AC-27", "AC-28", "AC-33")
def test_a_bus_error_shows_with_counters_and_code(on_bus: Any) -> None:
    tb = block(bSCFilter=SC_BUSERR)
    assert on_bus.ACAN_Register(tb)
    assert on_bus.ACAN_SendMessage(raw(1), 1)
    told(tb)
    assert (tb.bTEC, tb.bREC) == (8, 0)
    assert tb.bECC & 0x1F == 0x19  # acknowledge slot
    assert on_bus.ACAN_AckEvent(tb) == SC_BUSERR << 8 | TBS_SC
    assert tb.wStatus == 0


@pytest.mark.conforms("AC-26", "AC-35")
def test_registration_is_checked(library: Any) -> None:
    tb = block()
    assert library.ACAN_Register(block(bNotType=9)) is False
    assert "bNotType" in str(library.last_error())
    assert library.ACAN_Deregister(tb) is False
    assert library.ACAN_Register(tb) is True
    assert library.ACAN_Register(tb) is False
    assert library.ACAN_AckEvent(block()) == library.ACAN_AckEventCheck(block()) == 0
    assert library.ACAN_Deregister(tb) is True
    assert library.ACAN_AckEventCheck(tb) == 0
    assert library.ACAN_RetrieveMessages(tb) == -1
    assert library.ACAN_Register(tb) is True


@pytest.mark.conforms("AC-35")
def test_null_is_answered_too(library: Any) -> None:
    nothing: Any = None
    assert library.ACAN_Register(nothing) is False
    assert library.ACAN_Deregister(nothing) is False
    assert library.ACAN_SetHardConfig(nothing) is False
    assert library.ACAN_GetHardConfig(nothing) is False
    assert library.ACAN_SendMessage(nothing, 1) is False
    assert library.ACAN_AckEventCheck(nothing) == 0
    assert library.ACAN_RetrieveMessages(nothing) == -1


@pytest.mark.conforms("AC-30")
@pytest.mark.parametrize("buffer", [None, bytearray(ACANMBSZ)])
def test_an_invalid_buffer_answers_minus_1(library: Any, buffer: Any) -> None:
    tb = block(lpBuf=buffer, wCount=2)
    assert library.ACAN_Register(tb)
    assert library.ACAN_RetrieveMessages(tb) == -1


@pytest.mark.conforms("AC-30", "AC-36")
def test_messages_may_lie_packed_in_fixed_memory(on_bus: Any, peer: Peer) -> None:
    fifo, buffer = (on_bus.ACAN_AllocFixedMemory(4 * ACANMBSZ) for _ in range(2))
    tb = block(lpRMB=fifo, wRMBSize=4, lpBuf=buffer, wCount=4)
    assert on_bus.ACAN_Register(tb)
    peer.send(Frame(0x123, b"ab"))
    told(tb)
    assert on_bus.ACAN_RetrieveMessages(tb) == 1
    expected = raw(0x123, b"ab")
    assert (ACANMB.unpack(fifo[:ACANMBSZ]), ACANMB.unpack(buffer[:ACANMBSZ])) == (expected, expected)
    assert on_bus.ACAN_FreeFixedMemory(fifo, len(fifo))


@pytest.mark.conforms("AC-36")
def test_fixed_memory_is_zero_and_freed_once() -> None:
    memory = api.ACAN_AllocFixedMemory(100)
    assert memory == bytes(100)
    assert memory is not None
    memory[5] = 7
    assert api.ACAN_FreeFixedMemory(memory, 99) is False
    assert api.ACAN_FreeFixedMemory(bytearray(100), 100) is False
    assert api.ACAN_FreeFixedMemory(memory, 100) is True
    assert api.ACAN_FreeFixedMemory(memory, 100) is False
    assert [api.ACAN_AllocFixedMemory(size) for size in (0, -1, 1 << 62)] == [None, None, None]


@pytest.mark.conforms("AC-35")
def test_exit_cleans_up_what_an_application_left(on_bus: Any, hub: canwire.Hub) -> None:
    tb, memory = block(), on_bus.ACAN_AllocFixedMemory(10)
    assert on_bus.ACAN_Register(tb)
    on_bus.ACAN_Exit()
    on_bus.ACAN_Exit()
    status = hub.line_status(hub.board("HW000104").id, 0)
    assert (status.channels, status.control_holder) == (0, "")
    assert (status.running, status.initialised) == (False, True)
    assert on_bus.ACAN_FreeFixedMemory(memory, 10) is False
    assert on_bus.ACAN_Init() == 0x0100
    assert on_bus.ACAN_AckEventCheck(tb) == 0
    assert on_bus.ACAN_Register(tb)


def test_in_virtual_time_acknowledging_looks_at_what_has_come(virtual: Virtual) -> None:
    api.use(virtual.hub)
    assert api.ACAN_Init() == 0x0100
    tb, peer = block(), virtual.peer()
    assert api.ACAN_Register(tb)
    peer.send(Frame(1))
    virtual.hub.run_for(0.01)
    assert api.ACAN_AckEvent(tb) == TBS_MB
    assert tb.hEvent.is_set()
    assert api.ACAN_RetrieveMessages(tb) == 1
    api.use(None)
