"""What users of other interfaces met first, as it is now; how a bus ends is in test_ends.py."""

from __future__ import annotations

import importlib.metadata
import logging
import re
import threading
import time
import tomllib
from contextlib import suppress
from pathlib import Path

import can
import pytest

import canwire
from canwire.bus.can.faults.faults import Faults
from canwire.python_can import CanwireBus
from canwire.python_can.company import Company
from tests.hubs import Served, connected, embedded, left_meanwhile, stopped_meanwhile
from tests.python_can.conftest import ROOT
from tests.python_can.programs import Open

LONG = 30


def message(id: int = 0x123, data: bytes = b"\1\2") -> can.Message:
    return can.Message(arbitration_id=id, data=data, is_extended_id=id > 0x7FF)


@pytest.mark.finding("python-can 3")
def test_python_can_before_4_5_is_not_asked_for() -> None:
    """Its 4.4 hands periodic tasks a modifier where 4.5 says whether to start them."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    named = [one for extra in extras.values() for one in extra if re.match(r"python-can\b", one)]
    assert named == ["python-can>=4.5,<5"] * len(named)
    assert len(named) >= 2
    assert tuple(map(int, importlib.metadata.version("python-can").split(".")[:2])) >= (4, 5)


@pytest.mark.finding("python-can 4")
def test_the_state_of_an_adapter_that_is_gone(served: Served, open_bus: Open) -> None:
    """A port where nothing answers: the line runs, nothing takes part."""
    with canwire.connect(served.address) as hub:
        hub.plug("python-can", port="nosuch/none")
    bus = open_bus("python-can:0", bitrate=500_000)
    assert bus.line_status().state == canwire.ErrorState.STOPPED
    assert bus.line_status().running
    assert bus.state is can.BusState.ERROR


@pytest.mark.finding("python-can 9")
def test_how_late_a_real_adapters_stamps_are_nobody_knows(served: Served, open_bus: Open) -> None:
    with canwire.connect(served.address) as hub:
        hub.plug("python-can", port="virtual/late")
    bus = open_bus("python-can:0")
    assert bus.timestamp_error == float("inf")
    assert not bus.hardware_timestamps
    assert open_bus().timestamp_error < 1


@pytest.mark.finding("python-can 5")
def test_a_private_hub_is_said_to_be_one(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("CANWIRE_HUB", raising=False)
    monkeypatch.setattr(Company, "_told_of_private_hub", False)
    with caplog.at_level(logging.WARNING, "can.canwire"), CanwireBus() as one, CanwireBus() as other:
        assert one.channel_info.endswith("hub in this process")
        assert other.channel_info.endswith("hub in this process")
    assert [record.message.count("canwire serve") for record in caplog.records] == [1]


@pytest.mark.finding("python-can 5")
def test_a_shared_hub_needs_no_word(open_bus: Open, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO, "can.canwire"):
        assert "this process" not in open_bus().channel_info
    assert not caplog.records


@pytest.mark.finding("python-can 6")
@pytest.mark.parametrize("how", ["receiving", "waiting", "shutdown"])
def test_who_is_alone_on_the_bus_is_told(open_bus: Open, caplog: pytest.LogCaptureFixture, how: str) -> None:
    with caplog.at_level(logging.WARNING, "can.canwire"):
        bus = open_bus(tx_fifo_size=2, error_frames=False)
        bus.send(message())
        if how == "receiving":
            while not caplog.records:
                assert bus.recv(0.1) is None
        elif how == "waiting":
            bus.send(message())
            while not caplog.records:
                with suppress(can.CanTimeoutError):
                    bus.send(message(), timeout=0.6)
        else:
            bus.shutdown()
    said = [record.message for record in caplog.records]
    assert sum("no node acknowledges" in text for text in said) == 1 if how != "shutdown" else True
    assert "second node" in said[0] or "did not go out" in said[0]


@pytest.mark.finding("python-can 6")
def test_in_company_nothing_is_said(open_bus: Open, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "can.canwire"):
        a, b = open_bus(), open_bus()
        a.send(message())
        assert b.recv(LONG) is not None
        a.shutdown()
    assert not caplog.records


@pytest.mark.finding("python-can 7")
def test_no_message_is_missed_while_filters_change(open_bus: Open) -> None:
    """Every filter here lets 0x100 pass."""
    a, b = open_bus(), open_bus(can_filters=[{"can_id": 0x100, "can_mask": 0x7FF}])
    changes, between = 20, 50
    count, permits = changes * between, threading.Semaphore(0)

    def send() -> None:
        for k in range(count):
            permits.acquire()
            a.send(message(0x100, k.to_bytes(2, "big")))

    thread = threading.Thread(target=send)
    thread.start()
    for change in range(changes):
        permits.release(between)
        b.set_filters([{"can_id": 0x100, "can_mask": 0x7FF}, {"can_id": change, "can_mask": 0x7FF}])
    thread.join()
    heard = [int.from_bytes(b.recv(LONG).data, "big") for _ in range(count)]
    assert heard == list(range(count))


@pytest.mark.finding("python-can 7")
def test_a_narrower_filter_holds_for_what_waits_already(open_bus: Open) -> None:
    a, b = open_bus(), open_bus()
    for id in (1, 2, 3):
        a.send(message(id))
    while b._line_channel.reading.ring.fill() < 3:
        time.sleep(0.001)
    b.set_filters([{"can_id": 2, "can_mask": 0x7FF}])
    a.send(message(4))
    a.send(message(2))
    assert [b.recv(LONG).arbitration_id for _ in range(2)] == [2, 2]
    assert b.recv(0.05) is None


@pytest.mark.finding("python-can 10.3")
@pytest.mark.parametrize("reads", [True, False])
def test_a_bus_off_line_takes_no_messages(reads: bool) -> None:
    two_lines = '[[bus]]\nname = "can0"\n[[board]]\nkind = "usb-to-can-fd"\nserial = "HW000001"\n'
    two_lines += 'buses = ["can0", "can0"]\n'
    with (
        embedded(two_lines, time="virtual") as engine,
        connected(engine) as hub,
        CanwireBus("HW000001:0", hub=hub) as sender,
        CanwireBus("HW000001:1", hub=hub),
    ):
        Faults(engine.world.buses["can0"], seed=0).flip(bit="crc", times=32, seen_by="sender")
        sender.send(message())
        while sender.state is not can.BusState.ERROR:
            hub.run_for(0.001)
        if reads:
            while sender.recv(0) is not None:
                pass
        else:
            sender.send(message())  # nothing has said so yet
            hub.run_for(0.6)
        with pytest.raises(can.CanOperationError, match="bus-off"):
            sender.send(message())
        sender.state = can.BusState.ACTIVE
        sender.send(message())


@pytest.mark.finding("socketcan 1")
def test_a_line_that_is_stopped_while_its_bus_is_opened_says_so(hub: canwire.Hub) -> None:
    with stopped_meanwhile(hub), CanwireBus("HW000001:0", hub=hub) as bus:
        told = bus.recv(0)
        assert told is not None
        assert told.is_error_frame
        with pytest.raises(can.CanOperationError, match="does not run"):
            bus.send(message())
    with stopped_meanwhile(hub), CanwireBus("HW000001:0", hub=hub, error_frames=False) as bus:
        assert bus.recv(0) is None
        with pytest.raises(can.CanOperationError, match="does not run"):
            bus.send(message())


@pytest.mark.finding("socketcan 1")
def test_whoever_had_the_line_running_may_leave_while_a_bus_is_opened(hub: canwire.Hub) -> None:
    with (
        CanwireBus("HW000001:0", hub=hub, bitrate=250_000) as other,
        left_meanwhile(other._line_channel),
        CanwireBus("HW000001:0", hub=hub) as bus,
    ):
        assert bus.line_status().running
        assert bus.recv(0) is None


@pytest.mark.finding("python-can 10.4")
def test_a_rate_that_the_clock_does_not_divide_to_agrees_with_itself(open_bus: Open) -> None:
    open_bus("HW000001:0", bitrate=123_456)
    assert open_bus("HW000001:0", bitrate=123_456).line_status().mode.timing.bit_rate == 123_457
    with pytest.raises(can.CanInitializationError, match="123457"):
        open_bus("HW000001:0", bitrate=123_000)


@pytest.mark.finding("python-can 10.6")
def test_socketcans_way_to_leave_error_frames_out(open_bus: Open) -> None:
    bus = open_bus("HW000001:0", ignore_rx_error_frames=True, local_loopback=True)
    bus.send(message())
    while bus.line_status().state != canwire.ErrorState.ERROR_PASSIVE:
        assert bus.recv(0) is None
    assert bus.recv(0.05) is None


@pytest.mark.finding("issue 15.6")
@pytest.mark.parametrize(
    ("argument", "hint"),
    [
        ({"bit_rate": 250_000}, "did you mean bitrate"),
        ({"recieve_own_messages": True}, "receive_own_messages"),
        ({"local_loopback": False}, "always receive each other"),
        ({"xyzzy": 1}, "there are channel, can_filters, bitrate"),
    ],
)
def test_arguments_that_nobody_knows_are_refused(
    open_bus: Open, argument: dict[str, object], hint: str
) -> None:
    with pytest.raises(can.CanInitializationError, match=hint):
        open_bus(**argument)


@pytest.mark.finding("issue 15.7")
def test_a_line_at_another_rate_is_refused_with_the_way_out(open_bus: Open) -> None:
    open_bus("HW000001:0", bitrate=250_000)
    with pytest.raises(can.CanInitializationError, match="leave the bit rates out, or ask for the same"):
        open_bus("HW000001:0", bitrate=500_000)


def test_what_other_interfaces_know_alone_is_a_warning() -> None:
    """python-can's own tests give `single_handle` to every interface."""
    with pytest.warns(UserWarning, match="single_handle=True has no effect"):
        bus = can.Bus(interface="canwire", channel="can0", single_handle=True)
    bus.shutdown()
