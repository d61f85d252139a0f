"""`reconnect=True`: a bus continues once its hub or its board is back, with the same settings."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import can
import pytest

import canwire
from canwire.python_can import CanwireBus
from tests.hubs import Served, offering, served_here, serving
from tests.python_can.programs import Program

pytestmark = pytest.mark.conforms("N-59")
LONG = 30
CONFIG = '[[bus]]\nname = "can0"\n' + 3 * '[[board]]\nkind = "usb-to-can-fd"\n'


def message(id: int, data: bytes = b"\1\2") -> can.Message:
    return can.Message(arbitration_id=id, data=data, is_extended_id=False)


@pytest.fixture
def closing() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


class Heard(can.Listener):
    """What a Notifier passes on; `await_id` waits for one of these messages."""

    def __init__(self) -> None:
        self.ids: list[int] = []
        self._changed = threading.Condition()

    def on_message_received(self, msg: can.Message) -> None:
        with self._changed:
            self.ids.append(msg.arbitration_id)
            self._changed.notify_all()

    def await_id(self, id: int) -> None:
        with self._changed:
            assert self._changed.wait_for(lambda: id in self.ids, LONG), self.ids


def opened(closing: ExitStack, address: str, channel: str = "can0", **arguments: object) -> CanwireBus:
    bus = CanwireBus(channel, hub=address, reconnect=True, **arguments)  # type: ignore[arg-type]
    closing.callback(bus.shutdown)
    return bus


def stop(process: int) -> None:
    """No thread of it takes anything any more."""
    os.kill(process, signal.SIGSTOP)
    threads = list(Path(f"/proc/{process}/task").iterdir())
    while any(") T " not in (thread / "stat").read_text() for thread in threads):
        pass


def until(happened: Callable[[], bool], bus: CanwireBus) -> None:
    """Receive until something is so."""
    for _ in range(100 * LONG):
        if happened():
            return
        bus.recv(0.01)
    raise AssertionError("it did not happen")


def test_a_hub_that_was_killed_and_started_again(
    tmp_path: Path, closing: ExitStack, caplog: pytest.LogCaptureFixture
) -> None:
    """Programs with a Notifier, filters, own messages, a periodic task and a rate that only one of them names."""
    heard = Heard()
    with serving(tmp_path, CONFIG, time="real") as (address, process):
        bus = opened(
            closing,
            address,
            bitrate=250_000,
            receive_own_messages=True,
            can_filters=[{"can_id": 0x100, "can_mask": 0x700}],
        )
        other = opened(closing, address)
        lines = bus.channel_info, other.channel_info
        closing.callback(can.Notifier(bus, [heard], timeout=0.05).stop)
        task = other.send_periodic(message(0x111), 0.01)
        heard.await_id(0x111)
        stop(process.pid)
        for k in range(5):
            bus.send(message(0x150 + k))
        process.kill()
    until(lambda: bus.missed.times == other.missed.times == 1, other)
    with pytest.raises(can.CanOperationError, match="connects again by itself"):
        bus.send(message(0x160))
    heard.ids.clear()
    with serving(tmp_path, CONFIG, time="real"):
        heard.await_id(0x111)
        assert (bus.channel_info, other.channel_info) == lines
        assert bus.line_status().mode.timing.bit_rate == 250_000  # type: ignore[union-attr]
        task.stop()
        bus.send(message(0x222))
        bus.send(message(0x122))
        heard.await_id(0x122)
        got = [other.recv(LONG), other.recv(LONG)]
        assert [one.arbitration_id for one in got if one] == [0x222, 0x122]
        assert set(heard.ids) == {0x111, 0x122}
        assert bus.missed.unsent == 5
        assert bus.missed.seconds > 0
    told = [record.message for record in caplog.records if "connected again" in record.message]
    assert len(told) == 2
    assert all("s before were missed, and" in line for line in told)


def test_a_board_that_was_pulled(tmp_path: Path, closing: ExitStack) -> None:
    with served_here(tmp_path, CONFIG, time="real") as address, canwire.connect(address) as hub:
        serial = hub.boards()[1].hardware_id
        bus = opened(closing, address, f"{serial}:0")
        other = opened(closing, address)
        hub.unplug(serial)
        until(lambda: bus.missed.times == 1, bus)
        with pytest.raises(can.CanOperationError, match="connects again by itself"):
            bus.send(message(1))
        hub.plug("usb-to-can-fd", serial, buses=("can0", "", ""))
        until(lambda: bus.missed.seconds > 0, bus)
        bus.send(message(2))
        got = other.recv(LONG)
        assert got is not None
        assert got.arbitration_id == 2
        closing.close()


def test_a_thread_of_python_can_sends_again(tmp_path: Path, closing: ExitStack) -> None:
    with served_here(tmp_path, CONFIG, time="real") as address:
        bus, other = opened(closing, address), opened(closing, address)
        bus.send_periodic(message(0x111), 0.01003)  # no multiple of the list's ticks
        assert other.recv(LONG) is not None
    until(lambda: bus.missed.unsent > 2, other)
    with served_here(tmp_path, CONFIG, time="real"):
        until(lambda: other.missed.seconds > 0, other)
        assert other.recv(LONG) is not None
        closing.close()


def test_a_periodic_task_that_ends_in_the_meantime(tmp_path: Path, closing: ExitStack) -> None:
    with served_here(tmp_path, CONFIG, time="real") as address:
        bus, other = opened(closing, address), opened(closing, address)
        bus.send_periodic(message(0x111), 0.01, duration=0.05)
        stopped = bus.send_periodic(message(0x112), 0.01)
        assert other.recv(LONG) is not None
    until(lambda: bus.missed.times == other.missed.times == 1, bus)
    stopped.stop()
    until(lambda: all(not task.displaced for task in bus._returning._tasks), bus)  # type: ignore[union-attr]
    while other.recv(0):
        pass
    with served_here(tmp_path, CONFIG, time="real"):
        until(lambda: bus.missed.seconds > 0 and other.missed.seconds > 0, bus)
        bus.send(message(0x333))
        got = other.recv(LONG)
        assert got is not None
        assert got.arbitration_id == 0x333
        closing.close()


def test_shutdown_while_the_hub_is_away(
    tmp_path: Path, closing: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    with served_here(tmp_path, CONFIG, time="real") as address:
        bus = opened(closing, address)
    until(lambda: bus.missed.times == 1, bus)
    got: list[can.Message | None] = []
    waits = threading.Event()
    changed = bus._returning._changed  # type: ignore[union-attr]
    wait_for = changed.wait_for

    def wait(*condition: Any) -> Any:
        waits.set()  # with the lock, which shutdown needs
        return wait_for(*condition)

    monkeypatch.setattr(changed, "wait_for", wait)
    waiting = threading.Thread(target=lambda: got.append(bus.recv()))
    waiting.start()
    assert waits.wait(LONG)
    bus.shutdown()
    waiting.join(LONG)
    assert got == [None]
    with pytest.raises(can.CanOperationError, match="was shut down"):
        bus.recv(0)
    with served_here(tmp_path, CONFIG, time="real"), canwire.connect(address) as hub:
        assert all(
            not status.channels for _, status in canwire.lines_now(hub, canwire.every_line(hub, "CAN"))
        )


def test_what_cannot_be_connected_again_is_refused(tmp_path: Path) -> None:
    with pytest.raises(can.CanInitializationError, match="reconnect='yes': True or False"):
        CanwireBus(reconnect="yes")  # type: ignore[arg-type]
    with (
        canwire.connect(time="virtual") as hub,
        pytest.raises(can.CanInitializationError, match="give its address"),
    ):
        CanwireBus(hub=hub, reconnect=True)


def test_python_cans_logger(tmp_path: Path, served: Served, program: Program, closing: ExitStack) -> None:
    """It is unchanged, and so is its way to pass arguments on."""
    logger = program(
        "import sys, can.logger\n"
        "sys.argv = ['logger', '-i', 'canwire', '-c', 'can0', '--bus-kwargs', 'reconnect=True']\n"
        "print('ready', flush=True); can.logger.main()"
    )
    assert logger.stdout is not None
    bus = opened(closing, served.address)
    task = bus.send_periodic(message(0x111), 0.01)
    while " 111 " not in (line := logger.stdout.readline()):
        assert line
    served.process.kill()
    task.modify_data(message(0x111, b"\x22"))
    with serving(tmp_path, time="real"):
        while " 22 " not in (line := logger.stdout.readline()):
            assert line
        closing.close()


def test_a_hub_elsewhere_that_is_offered_again(tmp_path: Path, closing: ExitStack) -> None:
    with served_here(tmp_path, CONFIG, time="real") as local:
        sender = opened(closing, local)
        with offering(local) as (address, process):
            bus = opened(closing, address, can_filters=[{"can_id": 0x100, "can_mask": 0x700}])
            process.kill()
        until(lambda: bus.missed.times == 1, bus)
        sender.send_periodic(message(0x122), 0.01)  # nobody acknowledges it until the bus is back
        with offering(local, port=int(address.rpartition(":")[2])):
            until(lambda: bus.missed.seconds > 0, bus)
            got = bus.recv(LONG)
            while got is not None and got.is_error_frame:
                got = bus.recv(LONG)
            assert got is not None
            assert got.arbitration_id == 0x122
            closing.close()
