"""Protocols' libraries with threads of their own, and canwire's recorder, in virtual time: the same every time."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import Hub

can = pytest.importorskip("can")

from tests.threads.test_libraries import bus_on, twice  # noqa: E402  (python-can is an extra)

pytestmark = [
    pytest.mark.conforms("N-61"),
    pytest.mark.finding("first-hour 1"),
    pytest.mark.finding("machines 4"),
    pytest.mark.timeout(60),
]
VIN = b"CANWIRE0123456789"


@contextmanager
def iso_tp(hub: Hub, rxid: int, txid: int) -> Iterator[Any]:
    isotp = pytest.importorskip("isotp")
    with bus_on(hub) as bus, can.Notifier(bus, []) as notifier:
        yield isotp.NotifierBasedCanStack(bus, notifier, address=isotp.Address(rxid=rxid, txid=txid))


def answer_uds(stack: Any, stop: threading.Event) -> None:
    """A control unit in a thread: it needs 1.5 s for what it is asked to read, and says so."""
    stack.start()
    while not stop.is_set():
        request = stack.recv(block=True, timeout=0.2)
        if request is not None and request[0] == 0x10:
            stack.send(bytes((0x50, request[1], 0, 50, 1, 0xF4)))
        elif request is not None and request[0] == 0x22:
            stack.send(b"\x7f\x22\x78")
            time.sleep(1.5)
            stack.send(b"\x62" + request[1:3] + VIN)
    stack.stop()


def test_udsoncans_client_asks_a_control_unit_in_a_thread() -> None:
    """can-isotp's threads ask their queues with a rest of 1e-17 s: time stood, and they went round for ever."""
    udsoncan = pytest.importorskip("udsoncan")
    from udsoncan.client import Client
    from udsoncan.connections import PythonIsoTpConnection

    codecs = {"data_identifiers": {0xF190: udsoncan.AsciiCodec(len(VIN))}}
    config = {**udsoncan.configs.default_client_config, **codecs}

    def play(hub: Hub) -> list[object]:
        stop = threading.Event()
        with iso_tp(hub, 0x7E8, 0x7E0) as tester, iso_tp(hub, 0x7E0, 0x7E8) as own:
            ecu = threading.Thread(target=answer_uds, args=(own, stop))
            ecu.start()
            with Client(PythonIsoTpConnection(tester), config=config) as client:
                client.change_session(3)
                heard = [client.read_data_by_identifier(0xF190).service_data.values[0xF190]]
                heard += [time.monotonic()]
                with pytest.raises(udsoncan.exceptions.TimeoutException):
                    client.ecu_reset(1)
            stop.set()
            ecu.join()
        return heard

    vin, answered_s, _ = twice(play)
    assert vin == VIN.decode()
    assert isinstance(answered_s, float)
    assert 1.5 < answered_s < 1.6


def test_can_j1939_claims_addresses_and_sends_by_its_threads() -> None:
    j1939 = pytest.importorskip("j1939")

    def play(hub: Hub) -> list[object]:
        heard: list[object] = []
        units = [j1939.ElectronicControlUnit() for _ in range(2)]
        for unit in units:
            unit.connect(interface="canwire", channel="can0", hub=hub)
        sender, receiver = (
            unit.add_ca(name=j1939.Name(identity_number=number + 1), device_address=128 + number)
            for number, unit in enumerate(units)
        )

        def received(priority: int, group: int, source: int, timestamp: float, data: bytearray) -> None:
            heard.append((group, source, bytes(data), time.monotonic_ns()))

        def each_time(cookie: object) -> bool:
            sender.send_pgn(0, 0xFE, 0xCA, 6, [2] * 8)
            return True

        receiver.subscribe(received)
        for one in (sender, receiver):
            one.start()
        time.sleep(1)
        sender.send_pgn(0, 0xEF, 129, 6, list(range(100)))  # by RTS and CTS
        sender.add_timer(0.25, each_time)
        time.sleep(1.1)
        sender.remove_timer(each_time)
        for unit in units:
            unit.disconnect()
        return [heard]

    heard = twice(play)[0]
    assert [one[:3] for one in heard if one[0] == 0xEF00] == [(0xEF00, 128, bytes(range(100)))]  # type: ignore[attr-defined]
    assert sum(one[0] == 0xFECA for one in heard) == 4  # type: ignore[attr-defined]


def test_a_recorder_of_canwires_own(tmp_path: Path) -> None:
    def play(hub: Hub) -> list[object]:
        file = tmp_path / "bus.log"
        place = canwire.find_lines(hub, "can0")[0]
        channel = hub.open_channel(place.board.id, place.line)
        channel.set_up(canwire.ChannelMode(1000, 0))
        channel.activate()
        with bus_on(hub, "HW000001:1") as sender, bus_on(hub, "HW000001:0"):
            with canwire.record(channel, file) as recorder:
                for number in range(5):
                    sender.send(can.Message(arbitration_id=number, is_extended_id=False))
                    time.sleep(0.3)
            assert (recorder.lost, recorder.error) == (0, None)
        return [file.read_text().splitlines()]

    lines = twice(play)[0]
    assert [line.split()[2] for line in lines] == [f"{number:03X}#" for number in range(5)]  # type: ignore[attr-defined]


def test_an_ecu_of_canwires_own_answers_in_a_lab() -> None:
    udsoncan = pytest.importorskip("udsoncan")
    pytest.importorskip("isotp")
    from udsoncan.client import Client

    from canwire.ecus import UdsConnection, UdsEcu

    with canwire.Lab() as lab, canwire.in_time(lab):
        bus = lab.can_bus("can0", bit_rate=500_000)
        bus.node("ecu", UdsEcu(identifiers={0xF190: VIN}))
        codecs = {"data_identifiers": {0xF190: udsoncan.AsciiCodec(len(VIN))}}
        config = {**udsoncan.configs.default_client_config, **codecs}
        heard: list[object] = []

        def ask() -> None:
            connection = UdsConnection(bus.node("tester"), request=0x7E0, response=0x7E8)
            with Client(connection, config=config) as client:
                heard.append(client.read_data_by_identifier(0xF190).service_data.values[0xF190])

        tester = threading.Thread(target=ask)
        tester.start()
        tester.join(1)
        assert heard == [VIN.decode()]
        assert time.monotonic() < 0.01
