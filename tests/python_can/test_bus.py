"""One program's buses: what they receive, refuse and tell."""

from __future__ import annotations

import asyncio
import time
from typing import Any

import can
import pytest

import canwire
from canwire import BitTiming, LineMode
from canwire.python_can import CanwireBus
from tests.hubs import Served
from tests.python_can.programs import Open

LONG = 30


def message(id: int = 0x123, data: bytes = b"\1\2", **more: Any) -> can.Message:
    return can.Message(arbitration_id=id, data=data, is_extended_id=id > 0x7FF, **more)


@pytest.mark.conforms("PL-13", "PL-15")
def test_messages_with_the_time_that_they_had_on_the_bus(open_bus: Open) -> None:
    a, b = open_bus(bitrate=500_000), open_bus()
    a.send(message())
    got = b.recv(LONG)
    assert (got.arbitration_id, got.data, got.is_rx, got.channel) == (0x123, b"\1\2", True, "can0")
    assert b.hardware_timestamps
    assert 0 < b.timestamp_error < 0.1
    assert abs(got.timestamp - time.time()) < 5
    assert a.recv(0) is None


@pytest.mark.conforms("PL-16")
def test_own_messages_come_back_once_they_went_through(open_bus: Open) -> None:
    a, b = open_bus(receive_own_messages=True), open_bus()
    a.send(message())
    own, got = a.recv(LONG), b.recv(LONG)
    assert not own.is_rx
    assert own.timestamp == got.timestamp


@pytest.mark.smoke
@pytest.mark.conforms("PL-13")
def test_programs_on_one_line_hear_each_other(open_bus: Open) -> None:
    open_bus("usb-to-can:0")  # acknowledges
    a = open_bus("HW000001:0", receive_own_messages=True)
    b, c = open_bus("HW000001:0"), open_bus("HW000001:0", can_filters=[{"can_id": 0x200, "can_mask": 0x7FF}])
    for id in (0x100, 0x200):
        a.send(message(id))
    assert [(a.recv(LONG).arbitration_id, b.recv(LONG).arbitration_id) for _ in range(2)] == [
        (256, 256),
        (512, 512),
    ]
    assert c.recv(LONG).arbitration_id == 0x200
    b.send(message(0x300))
    heard = a.recv(LONG)
    assert (heard.arbitration_id, heard.is_rx) == (0x300, True)
    assert b.recv(0) is None


@pytest.mark.conforms("PL-13")
@pytest.mark.parametrize("channel", ["can0", "HW000001:0"])
def test_who_comes_first_sets_the_rate(open_bus: Open, channel: str) -> None:
    open_bus(channel, bitrate=250_000)
    with pytest.raises(can.CanInitializationError, match=r"HW000001:0 .*250000 bit/s.*set by python-can: "):
        open_bus("HW000001:0", bitrate=500_000)
    assert open_bus(channel).line_status().mode.timing.bit_rate == 250_000
    assert open_bus(channel, bitrate=250_000).state is can.BusState.ACTIVE


@pytest.mark.conforms("PL-13", "N-03")
@pytest.mark.parametrize(("asked", "bit_rate"), [(None, 125_000), (125_000, 125_000), (500_000, 500_000)])
def test_a_line_that_was_set_up_and_stopped_goes_on_as_it_is(
    hub: canwire.Hub, asked: int | None, bit_rate: int
) -> None:
    """Unless another rate is asked for; nobody else is on the bus, so that there is no rate to be taken over."""
    board = hub.board("HW000001")
    with hub.open_channel(board.id, 0):
        with hub.open_control(board.id, 0) as control:
            control.initialise(LineMode(board.lines[0].capabilities.timing(125_000)))
        with CanwireBus("HW000001:0", hub=hub, bitrate=asked) as bus:
            status = bus.line_status()
            assert status.running
            assert status.mode.timing.bit_rate == bit_rate
            assert (status.mode.data_timing is None) == (bit_rate == 125_000)


@pytest.mark.conforms("N-03")
def test_a_line_of_its_own_at_another_rate_is_allowed_and_pointed_out(
    open_bus: Open, caplog: pytest.LogCaptureFixture
) -> None:
    open_bus("can0", bitrate=250_000)
    assert not caplog.messages
    assert open_bus("can0", bitrate=500_000).line_status().mode.timing.bit_rate == 500_000
    assert "can0: different bit rates on one bus: HW000001:0 at 250000 bit/s" in caplog.messages[0]


@pytest.mark.finding("wire-2 1")
def test_sample_points_that_could_not_work_on_copper_are_pointed_out(
    open_bus: Open, caplog: pytest.LogCaptureFixture
) -> None:
    """The two programs of the finding, 500k/4M at 87.5 % and at 75 %: told before a frame is sent."""
    late, early = (
        can.BitTimingFd.from_sample_point(80_000_000, 500_000, point, 4_000_000, 80) for point in (87.5, 75)
    )
    open_bus("can0", timing=late)
    assert not caplog.messages
    open_bus("can0", timing=early)
    assert (
        "can0: this could not work on copper: HW000001:1 (75 % and 80 % after BRS) and HW"
        in caplog.messages[0]
    )
    assert "give both the same sample points" in caplog.messages[0]


def test_more_buses_than_lines_share_them(open_bus: Open) -> None:
    buses = [open_bus() for _ in range(7)]
    assert len({str(bus).split(": ")[1] for bus in buses}) == 6
    buses[0].send(message())
    assert [bus.recv(LONG).arbitration_id for bus in buses[1:]] == [0x123] * 6


def test_can_fd(open_bus: Open) -> None:
    a, b = (open_bus(fd=True, data_bitrate=4_000_000) for _ in range(2))
    classic = open_bus("HW000001:1")
    assert (a.protocol, classic.protocol) == (can.CanProtocol.CAN_FD, can.CanProtocol.CAN_20)
    a.send(message(0x1234567, bytes(range(64)), is_fd=True, bitrate_switch=True))
    a.send(message(1))
    got = b.recv(LONG)
    assert (got.is_fd, got.bitrate_switch, got.dlc, bytes(got.data)) == (True, True, 64, bytes(range(64)))
    assert classic.recv(LONG).arbitration_id == 1
    with pytest.raises(can.CanOperationError, match="fd=True"):
        classic.send(message(is_fd=True))
    with pytest.raises(can.CanInitializationError, match="classic CAN only"):
        open_bus("usb-to-can:0", fd=True)


def test_bit_timings_at_the_clock_of_the_line(open_bus: Open) -> None:
    timing = can.BitTiming.from_sample_point(8_000_000, 250_000, 75)
    bus = open_bus("usb-to-can-fd:0", timing=timing)
    found = bus.line_status().mode.timing
    assert (found.bit_rate, round(100 * found.sample_point), found.clock_hz) == (250_000, 75, 80_000_000)
    fd = can.BitTimingFd.from_sample_point(80_000_000, 500_000, 80, 2_000_000, 80)
    with pytest.raises(can.CanInitializationError, match="250000"):
        open_bus("usb-to-can-fd:0", timing=fd)


@pytest.mark.conforms("PL-20")
def test_the_rate_is_found_on_the_bus(open_bus: Open) -> None:
    a, b = open_bus(bitrate=125_000), open_bus()
    task = a.send_periodic(message(), 0.002)
    found = open_bus("usb-to-can:0", auto_bitrate=True)
    task.stop()
    assert found.line_status().mode.timing.bit_rate == 125_000
    assert b.recv(LONG) is not None


@pytest.mark.conforms("PL-19")
def test_listening_only_is_one_parameter(open_bus: Open) -> None:
    a = open_bus("HW000001:0")
    quiet = open_bus("HW000001:1", state=can.BusState.PASSIVE)
    assert quiet.state is can.BusState.PASSIVE
    a.send(message())
    time.sleep(0.05)
    assert a.channel_status().pending == 1  # nobody acknowledges
    with pytest.raises(can.CanInitializationError, match="set by python-can"):
        open_bus("HW000001:0", state="passive")
    quiet.state = can.BusState.ACTIVE
    assert quiet.recv(LONG) is not None
    quiet.state = can.BusState.PASSIVE
    assert quiet.line_status().mode.listen_only
    with pytest.raises(ValueError, match="ACTIVE"):
        quiet.state = can.BusState.ERROR


@pytest.mark.conforms("N-01")
def test_a_bus_keeps_no_control(open_bus: Open, served: Served) -> None:
    bus = open_bus("HW000001:0")
    assert not bus.line_status().control_holder
    hub = canwire.connect(served.address, name="tester")
    with hub, hub.open_control(hub.board("HW000001").id, 0):
        with pytest.raises(can.CanOperationError, match="held by tester"):
            bus.state = can.BusState.PASSIVE
        bus.state = can.BusState.ACTIVE  # as it is
    bus.state = can.BusState.PASSIVE
    assert bus.state is can.BusState.PASSIVE


@pytest.mark.conforms("PL-18")
def test_error_counters_and_error_frames(open_bus: Open) -> None:
    alone = open_bus("HW000001:0", error_frames=True)
    states = open_bus("HW000001:0")
    silent = open_bus("HW000001:0", error_frames=False)
    alone.send(message())
    first = alone.recv(LONG)
    assert first.is_error_frame
    assert first.arbitration_id & 0xA0 == 0xA0  # no acknowledge, and a bus error
    got = states.recv(LONG)
    assert (got.is_error_frame, got.arbitration_id & 4, got.data[1] & 8) == (True, 4, 8)  # warning
    status = alone.line_status()
    assert status.tec >= 96
    assert status.last_error == canwire.ErrorKind.ACK
    assert silent.recv(0) is None


def test_backpressure(open_bus: Open) -> None:
    alone = open_bus("HW000001:0", tx_fifo_size=4)
    for _ in range(5):  # one is in the controller
        alone.send(message(), timeout=LONG)
    with pytest.raises(can.CanOperationError, match="4 messages already wait"):
        alone.send(message(), timeout=0)
    with pytest.raises(can.CanTimeoutError, match="none was sent"):
        alone.send(message(), timeout=0.05)
    alone.flush_tx_buffer()
    alone.send(message(), timeout=0)


def test_exclusive(open_bus: Open) -> None:
    with open_bus("HW000001:0", exclusive=True), pytest.raises(can.CanInitializationError, match="exclusive"):
        open_bus("HW000001:0")
    with open_bus("HW000001:0"), pytest.raises(can.CanInitializationError, match="1 channels"):
        open_bus("HW000001:0", exclusive=True)


def test_what_is_not_there(open_bus: Open) -> None:
    for name in ("can9", "HW000001:2", "HW000009:0", "pcan:0"):
        with pytest.raises(can.CanInitializationError, match="no"):
            open_bus(name)
    with pytest.raises(can.CanInitializationError):
        CanwireBus("can0", hub="/nowhere/hub.sock")


def test_shutdown(open_bus: Open) -> None:
    a, b = open_bus(), open_bus()
    for k in range(500):
        a.send(message(k))
    a.shutdown()  # what was sent still goes out
    a.shutdown()
    assert [b.recv(LONG).arbitration_id for _ in range(500)] == list(range(500))
    for use in (lambda: a.recv(0), lambda: a.send(message()), a.fileno, lambda: a.state):
        with pytest.raises(can.CanOperationError, match="closed"):
            use()


def test_filters_may_change(open_bus: Open) -> None:
    a = open_bus()
    early = open_bus(can_filters=[{"can_id": 0x100, "can_mask": 0x700, "extended": False}])
    late = open_bus()
    late.set_filters([{"can_id": 0x200, "can_mask": 0x7FF}])

    def heard(bus: CanwireBus, count: int) -> list[int]:
        """What comes after five messages of all kinds: so many, and no more."""
        for id in (0x100, 0x1FF, 0x200, 0x12345678, 0x7FE):
            a.send(message(id))
        got = []
        while (one := bus.recv(LONG if len(got) < count else 0.2)) is not None:
            got.append(one.arbitration_id)
        return got

    assert heard(early, 2) == [0x100, 0x1FF]
    assert heard(late, 2) == [0x200, 0x200]
    early.set_filters([{"can_id": 0x12345678, "can_mask": 0x1FFFFFFF, "extended": True}])
    late.filters = None
    assert heard(early, 1)[-1:] == [0x12345678]
    assert heard(late, 10)[-5:] == [0x100, 0x1FF, 0x200, 0x12345678, 0x7FE]


def test_unplugged_and_hub_lost(served: Served, open_bus: Open) -> None:
    a, b = open_bus("HW000001:0"), open_bus("usb-to-can:0")
    with canwire.connect(served.address) as hub:
        hub.unplug("HW000001")
    assert a.recv(LONG).is_error_frame  # stopped
    with pytest.raises(can.CanOperationError, match="HW000001"):
        a.recv(LONG)
    with pytest.raises(can.CanOperationError, match="HW000001"):
        a.send(message())
    served.process.kill()
    with pytest.raises(can.CanOperationError, match="hub is gone"):
        b.recv(LONG)
    with pytest.raises(can.CanOperationError, match="hub is gone"):
        b.send(message())
    b.shutdown()


def test_a_notifier_with_an_event_loop(open_bus: Open) -> None:
    a, b = open_bus(), open_bus()

    async def listen() -> list[int]:
        reader = can.AsyncBufferedReader()
        notifier = can.Notifier(b, [reader], loop=asyncio.get_running_loop())
        for k in range(300):
            a.send(message(k))
        got = [(await asyncio.wait_for(reader.get_message(), LONG)).arbitration_id for _ in range(300)]
        a.send(message(0x7FF))
        got.append((await asyncio.wait_for(reader.get_message(), LONG)).arbitration_id)
        notifier.stop()
        return got

    assert asyncio.run(listen()) == [*range(300), 0x7FF]


def test_an_event_loop_is_told_once_that_the_hub_is_gone(served: Served, open_bus: Open) -> None:
    bus = open_bus()
    failures: list[Any] = []

    async def listen() -> None:
        loop, told = asyncio.get_running_loop(), asyncio.Event()

        def fail(_: object, context: dict[str, Any]) -> None:
            failures.append(context["exception"])
            told.set()

        loop.set_exception_handler(fail)
        notifier = can.Notifier(bus, [], loop=loop)
        served.process.kill()
        await asyncio.wait_for(told.wait(), LONG)
        for _ in range(100):  # turns of the loop in which it could be told again
            await asyncio.sleep(0)
        notifier.stop()

    asyncio.run(listen())
    assert [type(failure) for failure in failures] == [can.CanOperationError]


def test_virtual_time_passes_while_one_waits(hub: canwire.Hub) -> None:
    with CanwireBus(hub=hub) as a, CanwireBus(hub=hub) as b:
        a.send(message())
        got = b.recv(1000)
        assert got is not None
        assert b.recv(1000) is None
        assert b.timestamp_error == float("inf")


def test_a_line_that_others_set_up(served: Served, open_bus: Open) -> None:
    with canwire.connect(served.address, name="somebody") as hub:
        board = hub.board("HW000001").id
        with hub.open_control(board, 0) as control:
            control.initialise(LineMode(BitTiming.for_bit_rate(100_000, clock_hz=80_000_000)))
            control.start()
            assert open_bus("HW000001:0").line_status().control_holder.startswith("somebody")
            with pytest.raises(can.CanInitializationError, match="for classic CAN"):
                open_bus("HW000001:0", fd=True)
            with pytest.raises(can.CanInitializationError, match="set by somebody"):
                open_bus("HW000001:0", bitrate=500_000)
