"""scapy's sockets over python-can, as published, in virtual time: they poll, and yet time passes."""

from __future__ import annotations

import threading
import time

import pytest

from canwire import Hub

can = pytest.importorskip("can")
pytest.importorskip("scapy")

from scapy.contrib import cansocket_python_can as scapy_can  # noqa: E402
from scapy.contrib.isotp import ISOTP, ISOTPSoftSocket  # noqa: E402
from scapy.contrib.isotp.isotp_soft_socket import TimeoutScheduler  # noqa: E402

from tests.threads.test_libraries import bus_on, twice  # noqa: E402

pytestmark = [pytest.mark.finding("first-hour 1"), pytest.mark.timeout(60)]


def socket_on(hub: Hub, line: str) -> scapy_can.PythonCANSocket:
    scapy_can.SocketsPool.last_call = 0.0  # scapy's for the whole process: a new hub's time begins anew
    return scapy_can.PythonCANSocket(interface="canwire", channel=line, hub=hub)


def test_sniff_hears_a_cyclic_task_until_its_timeout() -> None:
    def play(hub: Hub) -> list[object]:
        socket = socket_on(hub, "HW000001:0")
        with bus_on(hub, "HW000001:1") as sender:
            message = can.Message(arbitration_id=0x120, data=[1], is_extended_id=False)
            task = sender.send_periodic(message, 0.1)
            heard = socket.sniff(timeout=1.05)
            task.stop()
        socket.close()
        return [(packet.identifier, bytes(packet.data), float(packet.time)) for packet in heard]

    *heard, end_ns = twice(play)
    assert [one[:2] for one in heard] == [(0x120, b"\x01")] * 11  # type: ignore[index]
    assert isinstance(end_ns, int)
    assert 1_050_000_000 <= end_ns < 1_060_000_000


def test_iso_tp_by_scapys_own_threads() -> None:
    def play(hub: Hub) -> list[object]:
        here, there = socket_on(hub, "HW000001:0"), socket_on(hub, "HW000001:1")
        with (
            ISOTPSoftSocket(here, tx_id=0x7E0, rx_id=0x7E8) as tester,
            ISOTPSoftSocket(there, tx_id=0x7E8, rx_id=0x7E0) as ecu,
        ):
            sending = threading.Thread(target=tester.send, args=(ISOTP(bytes(range(100))),))
            sending.start()
            heard = ecu.sniff(count=1, timeout=2)
            sending.join()
        here.close()
        there.close()
        while (
            TimeoutScheduler._thread is not None
        ):  # one for the whole process: it is to end in this hub's time
            time.sleep(0.1)
        return [bytes(packet.data) for packet in heard]

    assert twice(play)[0] == bytes(range(100))
