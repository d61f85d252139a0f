"""Libraries with threads of their own, as published, in virtual time: the same every time, to the nanosecond."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import canwire
from canwire import Gateway, Hub
from tests.hubs import parsed

can = pytest.importorskip("can")
pytestmark = [
    pytest.mark.conforms("N-61"),
    pytest.mark.finding("first-hour 1"),
    pytest.mark.finding("machines 4"),
    pytest.mark.timeout(60),
]
TWO_BUSES = "".join(
    f'[[bus]]\nname = "can{number}"\n[[board]]\nkind = "usb-to-can"\nbuses = ["can{number}", "can{number}"]\n'
    for number in range(2)
)


@contextmanager
def virtual_hub() -> Iterator[Hub]:
    with canwire.connect(config=parsed(TWO_BUSES), time="virtual") as hub, canwire.in_time(hub):
        yield hub


def twice(play: Callable[[Hub], list[object]]) -> list[object]:
    """What it did, the same both times."""
    heard = []
    for _ in range(2):
        with virtual_hub() as hub:
            heard.append([*play(hub), time.monotonic_ns()])
    assert heard[0] == heard[1]
    return heard[0]


def bus_on(hub: Hub, name: str = "can0") -> can.BusABC:
    return can.Bus(name, interface="canwire", hub=hub)


def test_iso_tp_in_threads_at_both_ends() -> None:
    isotp = pytest.importorskip("isotp")

    def play(hub: Hub) -> list[object]:
        with (
            bus_on(hub) as here,
            bus_on(hub) as there,
            can.Notifier(here, []) as n,
            can.Notifier(there, []) as m,
        ):
            tester, ecu = (
                isotp.NotifierBasedCanStack(bus, notifier, address=isotp.Address(rxid=rxid, txid=txid))
                for bus, notifier, rxid, txid in ((here, n, 0x7E8, 0x7E0), (there, m, 0x7E0, 0x7E8))
            )
            tester.start()
            ecu.start()
            tester.send(bytes(range(200)))
            request = ecu.recv(block=True, timeout=2)
            ecu.send(request[::-1])
            answer = tester.recv(block=True, timeout=2)
            tester.stop()
            ecu.stop()
            return [bytes(request), bytes(answer)]

    request, answer, _ = twice(play)
    assert (request, answer) == (bytes(range(200)), bytes(range(200))[::-1])


def test_canopen_reads_writes_and_hears_a_heartbeat() -> None:
    canopen = pytest.importorskip("canopen")
    types = canopen.objectdictionary

    def dictionary() -> canopen.ObjectDictionary:
        objects = canopen.ObjectDictionary()
        for index, name, kind in (
            (0x1017, "heartbeat", types.UNSIGNED16),
            (0x2000, "speed", types.UNSIGNED32),
        ):
            entry = types.ODVariable(name, index)
            entry.data_type, entry.access_type, entry.default = kind, "rw", 7
            objects.add_object(entry)
        return objects

    def play(hub: Hub) -> list[object]:
        master, slave = canopen.Network(), canopen.Network()
        for network in (master, slave):
            network.connect(interface="canwire", channel="can0", hub=hub)
        ecu, remote = slave.create_node(5, dictionary()), master.add_node(5, dictionary())
        heard = [remote.sdo[0x2000].raw]
        remote.sdo[0x2000].raw = 99
        heard += [ecu.sdo[0x2000].raw]
        ecu.nmt.start_heartbeat(100)
        for _ in range(3):
            heard += [remote.nmt.wait_for_heartbeat(1), round(time.monotonic(), 1)]
        ecu.nmt.stop_heartbeat()
        for network in (master, slave):
            network.disconnect()
        return heard

    state = "PRE-OPERATIONAL"
    assert twice(play)[:-1] == [7, 99, state, 0.0, state, 0.1, state, 0.2]


def test_a_gateway_carries_frames_and_waits() -> None:
    def play(hub: Hub) -> list[object]:
        heard: list[object] = []
        with bus_on(hub) as here, bus_on(hub, "can1") as there, Gateway("can0", "can1", hub=hub) as gateway:
            for number in range(3):
                for sender, receiver in ((here, there), (there, here)):
                    sender.send(can.Message(arbitration_id=0x100 + number, is_extended_id=False))
                    arrived = receiver.recv(1)
                    assert arrived is not None
                    heard.append((arrived.timestamp, arrived.arbitration_id))
            heard.append(gateway.wait(2.0))
            heard.append((gateway.there.passed, gateway.back.passed))
        return heard

    heard = twice(play)
    assert [one[1] for one in heard[:6]] == [0x100, 0x100, 0x101, 0x101, 0x102, 0x102]  # type: ignore[index]
    assert heard[6:8] == [False, (3, 3)]


def test_python_cans_logger_writes_the_same_file(tmp_path: Path) -> None:
    def play(hub: Hub) -> list[object]:
        file = tmp_path / "bus.log"
        with (
            bus_on(hub) as reader,
            bus_on(hub) as sender,
            can.Logger(str(file)) as log,
            can.Notifier(reader, [log]),
        ):
            task = sender.send_periodic(can.Message(arbitration_id=0x120, is_extended_id=False), 0.1)
            time.sleep(1.05)
            task.stop()
        return [file.read_text().splitlines()]

    lines = twice(play)[0]
    assert len(lines) == 11  # type: ignore[arg-type]


def test_a_bus_for_many_threads() -> None:
    def play(hub: Hub) -> list[object]:
        heard: list[object] = []
        with can.ThreadSafeBus("can0", interface="canwire", hub=hub) as shared, bus_on(hub) as sender:

            def hear(name: str) -> None:
                while (message := shared.recv(0.5)) is not None:
                    heard.append((name, message.timestamp, message.arbitration_id))

            readers = [threading.Thread(target=hear, args=(name,)) for name in "ab"]
            for reader in readers:
                reader.start()
            for number in range(6):
                sender.send(can.Message(arbitration_id=number, is_extended_id=False))
                time.sleep(0.01)
            for reader in readers:
                reader.join()
        return heard

    assert sorted(one[2] for one in twice(play)[:-1]) == list(range(6))  # type: ignore[index]


def test_without_in_time_an_endless_wait_ends_with_a_word() -> None:
    """The buses' own clocks tick for ever: it was simulated for ever, and held the hub."""
    refused = pytest.raises(
        can.CanOperationError, match=r"an hour of the hub's time.*canwire\.in_time\(hub\)"
    )
    with canwire.connect(time="virtual") as hub, bus_on(hub) as bus, refused:
        bus.recv()
