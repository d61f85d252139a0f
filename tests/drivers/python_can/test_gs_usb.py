"""candleLight adapters: canwire's own driver of gs_usb's protocol, on a device that is made up."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from typing import Any

import pytest

from canwire import BitTiming, ChannelMode, ErrorKind, ErrorState, EventKind, Frame, Hub, LineMode, Siblings
from canwire.drivers.python_can.gs_usb import bus as gs_usb_bus
from canwire.drivers.python_can.gs_usb import devices
from tests.drivers.outside_bench import (
    TIMING,
    Program,
    a_frame,
    fresh_hub,
    gone,
    is_event,
    on_bus,
    trouble,
)
from tests.drivers.python_can.candle import FD, LISTEN_ONLY, STAMPS, Candle
from tests.hubs import LONG_S

FD_MODE = LineMode(
    BitTiming.for_bit_rate(500_000, 0.8, clock_hz=80_000_000),
    BitTiming.for_bit_rate(2_000_000, 0.75, clock_hz=80_000_000),
    long_data=True,
    error_frames=True,
)
_BIT_TIMING, _MODE, _DATA_BIT_TIMING = 1, 2, 10


@pytest.fixture
def hub() -> Iterator[Hub]:
    made = fresh_hub()
    yield made
    made.close()


@pytest.fixture
def there(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What is plugged in: a test changes it as it likes."""
    found: list[Any] = [Candle("AAA"), Candle("BBB")]
    monkeypatch.setattr(devices, "find_devices", lambda: list(found))
    monkeypatch.setattr(gs_usb_bus, "release", lambda device: None)
    return found


def plugged(hub: Hub, channel: str = "0", mode: LineMode | None = None) -> Program:
    return Program(hub, hub.plug("python-can", port=f"gs_usb/{channel}"), mode)


@pytest.mark.realtime
@pytest.mark.parametrize(("channel", "number"), [("0", 0), ("1", 1), ("BBB", 1), ("", 0)])
def test_it_is_chosen_by_number_and_by_serial_number(
    hub: Hub, there: list[Any], channel: str, number: int
) -> None:
    plugged(hub, channel).start()
    assert [bool(candle.requests) for candle in there] == [number == 0, number == 1]


@pytest.mark.realtime
def test_what_it_sent_itself_is_no_received_frame(hub: Hub, there: list[Any]) -> None:
    program = plugged(hub).start()
    other = program.hub.open_channel(program.board.id, 0)
    program.send(Frame(0x123, b"ab"))
    sent = program.wait(a_frame)[-1]
    there[0].say(0x123, b"ab")
    heard = program.wait(a_frame)[-1]
    other.close()

    assert (sent.self_received, heard.self_received) == (True, False)
    status = program.status()
    assert (status.frames_sent, status.frames_received) == (1, 1)
    assert len(there[0].written[0]) == 20


@pytest.mark.realtime
def test_two_programs_share_it(hub: Hub, there: list[Any]) -> None:
    """What one sends the other hears once, as from the bus, and both hear what comes from there."""
    program = plugged(hub).start()
    other = program.hub.open_channel(program.board.id, 0)
    other.set_up(ChannelMode(64, 64, siblings=Siblings.OTHERS))
    other.activate()
    program.send(Frame(0x123, b"ab"))
    there[0].say(0x456, b"cd")
    heard = [other.receive(LONG_S), other.receive(LONG_S)]
    found = program.wait(lambda one: isinstance(one, Frame) and one.id == 0x456)
    other.close()

    assert sorted(heard, key=lambda one: one.id) == [Frame(0x123, b"ab"), Frame(0x456, b"cd")]
    assert not found[-1].self_received
    assert program.status().frames_received == 1
    assert len(there[0].written) == 1


@pytest.mark.realtime
def test_a_frame_is_sent_when_the_bus_has_taken_it(hub: Hub, there: list[Any]) -> None:
    there[0].acknowledged = False
    program = plugged(hub).start()
    program.send(Frame(0x123))
    there[0].say(0x7)
    assert program.wait(a_frame)[-1].id == 0x7
    assert program.status().frames_sent == 0
    assert there[0].was_written.wait(LONG_S)
    there[0].echo(there[0].written[0])
    assert program.wait(a_frame)[-1].self_received
    assert program.status().frames_sent == 1


@pytest.mark.realtime
def test_fd_both_ways(hub: Hub, there: list[Any]) -> None:
    program = plugged(hub, mode=FD_MODE).start()
    frames = [
        Frame(0x1FFFFFFF, bytes(range(64)), extended=True, fd=True, bit_rate_switch=True),
        Frame(0x3, bytes(12), fd=True),
        Frame(0x1, remote=True, dlc=3),
    ]
    program.send(*frames)
    assert [program.wait(a_frame)[-1] for _ in frames] == frames
    assert [len(data) for data in there[0].written] == [76, 76, 20]
    there[0].say(0x80000123, bytes(48), flags=2 | 4 | 8, dlc=14)
    expected = Frame(
        0x123, bytes(48), extended=True, fd=True, bit_rate_switch=True, error_state_indicator=True
    )
    assert program.wait(a_frame)[-1] == expected

    asked = {request: data for request, _, data in there[0].requests}
    assert BitTiming(*_timing(asked[_BIT_TIMING]), clock_hz=80_000_000).bit_rate == 500_000
    assert BitTiming(*_timing(asked[_DATA_BIT_TIMING]), clock_hz=80_000_000).bit_rate == 2_000_000
    assert int.from_bytes(asked[_MODE][4:], "little") & (FD | STAMPS) == FD | STAMPS


def _timing(data: bytes) -> tuple[int, int, int, int]:
    """Prescaler, tseg1, tseg2, SJW."""
    prop, phase1, phase2, sjw, prescaler = (
        int.from_bytes(data[k : k + 4], "little") for k in range(0, 20, 4)
    )
    return prescaler, prop + phase1, phase2, sjw


@pytest.mark.realtime
def test_listening_only_is_its_mode(hub: Hub, there: list[Any]) -> None:
    plugged(hub, mode=LineMode(TIMING, listen_only=True)).start()
    mode = [data for request, _, data in there[0].requests if request == _MODE][-1]
    assert int.from_bytes(mode[4:], "little") & LISTEN_ONLY


@pytest.mark.realtime
def test_one_without_fd_says_so(hub: Hub, there: list[Any]) -> None:
    there[0] = Candle("AAA", fd=False)
    program = plugged(hub, mode=FD_MODE)
    program.control.start()
    program.wait(trouble(3))
    assert program.status().obstacle == "this gs_usb adapter does not know CAN FD"


@pytest.mark.realtime
def test_unplugged_and_plugged_again(hub: Hub, there: list[Any]) -> None:
    program = plugged(hub, "AAA").start()
    candle = there[0]
    candle.acknowledged = False
    program.send(Frame(0x1))
    there.remove(candle)
    candle.pull()
    found = program.wait(lambda one: is_event(one, EventKind.ABORTED))
    assert any(gone(one) for one in found)
    assert "unplugged" in program.status().obstacle or "AAA" in program.status().obstacle
    assert program.channel.status().aborted == 1
    program.send(Frame(0x2))
    there.append(Candle("AAA"))

    found = program.wait(a_frame)
    assert any(on_bus(one) for one in found)
    assert found[-1] == Frame(0x2)
    assert program.status().obstacle == ""


@pytest.mark.realtime
def test_errors_counters_and_lost_frames(hub: Hub, there: list[Any]) -> None:
    program = plugged(hub).start()
    there[0].say(0x20000204, bytes([0, 0x30, 0, 0, 0, 0, 130, 7]))
    state = program.wait(lambda one: is_event(one, EventKind.STATE))[-1]
    assert state.state is ErrorState.ERROR_PASSIVE
    assert (program.status().tec, program.status().rec) == (130, 7)
    there[0].say(0x20000088, bytes([0, 0, 4, 0, 0, 0, 0, 0]))
    assert program.wait(lambda one: is_event(one, EventKind.ERROR))[-1].error is ErrorKind.STUFF
    there[0].say(0x55, flags=1)
    assert is_event(program.next(), EventKind.OVERRUN)
    assert program.next() == Frame(0x55)


@pytest.mark.realtime
def test_time_stamps_go_on_after_they_wrap(hub: Hub, there: list[Any]) -> None:
    program = plugged(hub).start()
    for _ in range(3):
        there[0].say(0x1)
    first, second, third = (program.wait(a_frame)[-1].timestamp_ns for _ in range(3))
    assert first <= second <= third <= first + 3_000_000


@pytest.mark.realtime
@pytest.mark.parametrize(
    ("refusal", "words"),
    [
        (
            OSError(errno.EACCES, "Access denied (insufficient permissions)"),
            "/etc/udev/rules.d/70-canwire.rules",
        ),
        (OSError(errno.EBUSY, "Resource busy"), "gs_usb/0 is busy: another program has it open"),
    ],
)
def test_it_says_why_it_cannot_be_opened(hub: Hub, there: list[Any], refusal: OSError, words: str) -> None:
    there[0].refusal = refusal
    program = plugged(hub)
    program.control.start()
    program.wait(trouble(3))
    assert words in program.status().obstacle


@pytest.mark.realtime
def test_linux_keeps_its_interface(hub: Hub, there: list[Any]) -> None:
    there[0].kernel = True
    program = plugged(hub)
    program.control.start()
    program.wait(trouble(3))
    assert "socketcan/can0" in program.status().obstacle
    plugged(hub, "AAA?detach=true").start()


@pytest.mark.realtime
def test_the_second_channel_of_one_device(hub: Hub, there: list[Any]) -> None:
    there[0] = Candle("AAA", channels=2)
    program = plugged(hub, "0?port=1").start()
    there[0].say(0x1, channel=0)
    there[0].say(0x2, channel=1)
    assert program.wait(a_frame)[-1].id == 0x2
    assert {value for request, value, _ in there[0].requests if request == _MODE} == {1}


@pytest.mark.realtime
def test_none_of_that_name(hub: Hub, there: list[Any]) -> None:
    program = plugged(hub, "CCC")
    program.control.start()
    program.wait(trouble(3))
    assert "there is no gs_usb/CCC; found: gs_usb/AAA, gs_usb/BBB" in program.status().obstacle
