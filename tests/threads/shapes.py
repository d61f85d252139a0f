"""The five shapes that python-can programs commonly have, as ECUs, and a tester that writes down what they say.

Ordinary programs: nothing here knows of virtual time. An ECU runs until STOP; number N answers 0x100 + k with
0x110 * (N + 1) + k.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable

import can

STOP = 0x7FF
REQUESTS = 5
Shape = Callable[[can.BusABC, int], None]


def message(identifier: int, *data: int) -> can.Message:
    return can.Message(arbitration_id=identifier, data=data, is_extended_id=False)


def is_request(heard: can.Message) -> bool:
    return heard.arbitration_id & 0x7F0 == 0x100


def answer(heard: can.Message, number: int) -> can.Message:
    return message(0x110 * (number + 1) + (heard.arbitration_id & 0xF), *heard.data)


def iterating(bus: can.BusABC, number: int) -> None:
    for heard in bus:
        if heard.arbitration_id == STOP:
            return
        if is_request(heard):
            time.sleep(0.002)
            bus.send(answer(heard, number))


def receiving(bus: can.BusABC, number: int) -> None:
    while True:
        heard = bus.recv()
        if heard is None or heard.arbitration_id == STOP:
            return
        if is_request(heard):
            bus.send(answer(heard, number))


def notified(bus: can.BusABC, number: int) -> None:
    reader = can.BufferedReader()
    notifier = can.Notifier(bus, [reader])
    while (heard := reader.get_message(0.5)) is None or heard.arbitration_id != STOP:
        if heard is not None and is_request(heard):
            bus.send(answer(heard, number))
    notifier.stop()


def awaiting(bus: can.BusABC, number: int) -> None:
    async def main() -> None:
        reader = can.AsyncBufferedReader()
        notifier = can.Notifier(bus, [reader], loop=asyncio.get_running_loop())
        async for heard in reader:
            if heard.arbitration_id == STOP:
                break
            if is_request(heard):
                await asyncio.sleep(0.003)
                bus.send(answer(heard, number))
        notifier.stop()

    asyncio.run(main())


def cyclic(bus: can.BusABC, number: int) -> None:
    """One cyclic message by the hub's list, one by python-can's own thread."""
    tasks = [
        bus.send_periodic(message(0x300 + number, 1), 0.010),
        bus.send_periodic(message(0x310 + number, 2), 0.0151, modifier_callback=count_up),
    ]
    while (heard := bus.recv(0.2)) is None or heard.arbitration_id != STOP:
        if heard is not None and is_request(heard):
            bus.send(answer(heard, number))
    for task in tasks:
        task.stop()


def count_up(sent: can.Message) -> None:
    sent.data[0] = (sent.data[0] + 1) & 0xFF


SHAPES: dict[str, Shape] = {
    "iterating": iterating,
    "receiving": receiving,
    "notified": notified,
    "awaiting": awaiting,
    "cyclic": cyclic,
}


def tester(bus: can.BusABC) -> list[str]:
    """Asks, waits for quiet, and ends the ECUs; everything that it heard, with its time."""
    log: list[str] = []
    for number in range(REQUESTS):
        bus.send(message(0x100 + number, number))
        end_s = time.monotonic() + 0.050
        while (left_s := end_s - time.monotonic()) > 0:
            heard = bus.recv(left_s)
            if heard is not None:
                log.append(f"{heard.timestamp:.9f} {heard.arbitration_id:X} {heard.data.hex()}")
    bus.send(message(STOP))
    return log


def play(name: str, open_bus: Callable[[], can.BusABC]) -> list[str]:
    """Two ECUs of this shape in threads, and the tester in this one; the log, and the time at the end."""
    with open_bus() as first, open_bus() as second, open_bus() as own:
        ecus = [
            threading.Thread(target=SHAPES[name], args=(bus, number), name=f"ECU {number}")
            for number, bus in enumerate((first, second), 1)
        ]
        for ecu in ecus:
            ecu.start()
        log = tester(own)
        for ecu in ecus:
            ecu.join()
    return [*log, f"{time.monotonic():.9f}"]
