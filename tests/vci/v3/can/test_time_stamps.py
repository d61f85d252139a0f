"""Time stamps: ticks since the controller was started, 32 bits of them."""

from __future__ import annotations

from typing import Any

import pytest

from canwire.vci import v3
from tests.vci.v3.programs import NetProgram

COUNTER = 1 << 32


@pytest.fixture
def clocked(virtual_net: NetProgram) -> Any:
    """A program, a sender, a receiver whose line is to be started, and its control unit."""
    virtual_net.start(0)
    return virtual_net, virtual_net.port(0), virtual_net.port(1), virtual_net.control(1)


def seconds(socket: v3.CanSocket, ticks: int) -> float:
    return ticks * socket.time_stamp_counter_divisor / socket.clock_frequency


@pytest.mark.conforms("X3-34")
def test_ticks_count_from_the_start_of_the_controller(clocked: Any, message: Any) -> None:
    program, sender, receiver, control = clocked
    program.hub.run_for(0.123)
    started_ns = program.hub.now_ns()
    control.start_line()
    for wait_s in (0.0, 0.5, 2.0):
        program.hub.run_for(wait_s)
        sender.send(message(1))
        (one,) = receiver.receive()
        tick_s = seconds(control, 1)
        since_start_s = (program.hub.now_ns() - started_ns) / 1e9
        assert seconds(control, one.time_stamp) == pytest.approx(since_start_s, abs=2 * tick_s)


@pytest.mark.conforms("X3-34")
def test_after_stop_the_counter_runs_on_and_after_reset_it_starts_again(clocked: Any, message: Any) -> None:
    program, sender, receiver, control = clocked
    control.start_line()
    program.hub.run_for(1)
    control.stop_line()
    control.start_line()
    sender.send(message(1))
    assert receiver.receive()[0].time_stamp >= 1_000_000
    control.reset_line()
    control.start_line()
    sender.send(message(2))
    assert receiver.receive()[0].time_stamp < 1_000


@pytest.mark.conforms("X3-34")
def test_converted_time_survives_the_wrap_around(clocked: Any, message: Any) -> None:
    program, sender, receiver, control = clocked
    control.start_line()
    started_ns = program.hub.now_ns()
    wraps, stamps, times_s = 0, [], []
    for _ in range(3):
        program.hub.run_for(seconds(control, COUNTER) * 0.6)
        sender.send(message(1))
        while True:
            one = receiver.reader.read_message()
            if one is None:
                assert receiver.event.wait_one(1_000)
            elif one.frame_type == v3.CanMsgFrameType.TIME_OVERRUN:
                wraps += one.identifier
            elif one.frame_type == v3.CanMsgFrameType.DATA:
                break
        stamps.append(one.time_stamp)
        times_s.append(seconds(control, wraps * COUNTER + one.time_stamp))
        assert times_s[-1] == pytest.approx((program.hub.now_ns() - started_ns) / 1e9, abs=1e-5)
    assert stamps[1] < stamps[0]
    assert times_s == sorted(times_s)
    assert wraps == 1
