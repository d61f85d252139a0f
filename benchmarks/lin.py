"""One LIN bus: how much faster than real time it runs, and what it costs in real time."""

from __future__ import annotations

import contextlib
import time

import shared

import canwire

BIT_RATE = 19_200


def scene(lab: canwire.Lab) -> None:
    """A master with a schedule of eight frames, and two slaves that answer them."""
    bus = lab.lin_bus("lin0", bit_rate=BIT_RATE)
    bus.slave("doors", responses={id: bytes(8) for id in range(0x10, 0x14)})
    bus.slave("seats", responses={id: bytes(8) for id in range(0x20, 0x24)})
    bus.master(schedule=[*range(0x10, 0x14), *range(0x20, 0x24)])


def virtual(seconds: float) -> float:
    """Seconds of bus for each second of processor, in virtual time."""
    with canwire.Lab() as lab:
        scene(lab)
        began = time.perf_counter()
        lab.run_for(seconds)
        return seconds / (time.perf_counter() - began)


def real(seconds: float, *, heard: bool = False) -> float:
    """The share of a core that a hub with this bus takes in real time, in %; `heard`: a program waits for frames."""
    with shared.served("real") as process, canwire.connect(process.address) as hub:
        master = hub.open_lin_control(hub.boards()[0].id, 2)
        slave = hub.open_lin_control(hub.plug("usb-to-can-fd").id, 2)
        for control in (slave, master):
            control.initialise(canwire.LinMode(control is master, BIT_RATE))
        for id in range(0x10, 0x18):
            slave.respond(canwire.LinFrame(id, bytes(8)))
        for control in (slave, master):
            control.start()
        master.run_schedule(canwire.LinSchedule.of(range(0x10, 0x18), "all"))
        with contextlib.ExitStack() as held:
            monitor = held.enter_context(hub.open_monitor(hub.boards()[0].id, 2)) if heard else None
            if monitor is not None:
                monitor.set_up(canwire.LinMonitorMode(256))
                monitor.activate()
            used, until = process.processor_s(), time.perf_counter() + seconds
            while (left := until - time.perf_counter()) > 0:
                if monitor is None:
                    time.sleep(left)
                else:
                    monitor.receive(left)
            return 100 * (process.processor_s() - used) / seconds


def rows(scale: int, seconds: float) -> list[tuple[str, str, str, str]]:
    """For the table of run.py."""
    return [
        ("LIN at 19200, a schedule without end", f"{virtual(600 / scale):,.0f} x real time", "", "1,000 x"),
        ("  the same in real time, the hub", f"{real(seconds):.1f} % of a core", "", "< 1 %"),
        (
            "  and a program that waits for each frame",
            f"{real(seconds, heard=True):.1f} % of a core",
            "",
            "< 1 %",
        ),
    ]
