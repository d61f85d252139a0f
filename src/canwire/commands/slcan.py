"""`canwire slcan`: an emulated CANBUS dongle, for programs that talk to serial CAN adapters.

canwire slcan                                on a pseudo terminal: the link ttyCANBUS0, or the next that is free
canwire slcan --pty /tmp/can --bus can0      on that link, plugged into can0
canwire slcan --tcp 127.0.0.1:5000           for socket://127.0.0.1:5000; this machine only unless HOST says otherwise
canwire slcan --serial /dev/ttyUSB0          on a serial port (needs canwire[hardware])
canwire slcan --pty a --pty b                two dongles; the second one's serial number is the next

Each dongle is a separate board on the hub; without a hub, a hub runs in this process. A line shows where
each dongle is. SIGTERM and Ctrl-C unplug the dongles and report what was lost; a killed process's boards are
removed, too. The default links, and the setting of Z for each serial number, are in
$XDG_STATE_HOME/canwire (~/.local/state/canwire).

On a pseudo terminal a host can write faster than on any serial line, and then finds the queue of eight full (BELL);
--pace 115200 takes its bytes as such a line would. A hub in lockstep has dongles while its time is held to the clock
(canwire pace), since no hub can see what their hosts wait for.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import canwire
from canwire import BadValue, InUse, WrongState
from canwire.commands.console import complain
from canwire.commands.greeting import add_greeting_argument
from canwire.commands.shared_hub import add_hub_argument
from canwire.commands.shell.ending import signals_call
from canwire.slcan import (
    DIALECTS,
    DongleCounters,
    FileEeprom,
    PluggedDongle,
    PtyWire,
    SerialWire,
    Service,
    Settings,
    TcpWire,
    Wire,
)

if TYPE_CHECKING:
    from canwire import Hub

_MOST_LINKS = 100


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument(
        "--pty", metavar="LINK", action="append", default=[], help="a pseudo terminal, found by LINK"
    )
    parser.add_argument("--tcp", metavar="HOST:PORT", action="append", default=[], help="a TCP port")
    parser.add_argument("--serial", metavar="DEVICE", action="append", default=[], help="a serial port")
    parser.add_argument("--baud-rate", type=int, default=115_200, metavar="BAUD", help="of the serial port")
    parser.add_argument(
        "--pace",
        type=int,
        default=0,
        metavar="BAUD",
        help="take the host's bytes as a serial line at this rate would (default: as fast as they come)",
    )
    add_greeting_argument(parser, "sent a command to the TCP port")
    parser.add_argument("--bus", default="can0", help="plugged into this bus (default: can0)")
    parser.add_argument("--dialect", choices=sorted(DIALECTS), default="canbus", help="whose dongle it is")
    parser.add_argument(
        "--serial-number", default="A123", metavar="XXXX", help="the answer to N (default: A123)"
    )
    parser.add_argument("--version", default="", metavar="TEXT", help="the answer to V (default: V1013)")
    parser.add_argument(
        "--tx-reply",
        choices=("z", "cr"),
        default="z",
        help="the reply to t and T: z and CR (z), or CR alone (cr)",
    )
    parser.add_argument("--verbose", action="store_true", help="report openings, refusals and counters")
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Serve until SIGTERM, SIGHUP or SIGINT, or until the last dongle's board was pulled out."""
    with ExitStack() as closing:
        stop = canwire.Event(manual_reset=True)
        closing.callback(stop.close)
        closing.enter_context(signals_call(stop.set))
        service = Service(complain)
        hub = closing.enter_context(canwire.connect(arguments.hub, name="canwire slcan", timed=False))
        closing.callback(service.close)
        _check_time(hub)
        settings = _settings(arguments)
        for wire in _wires(arguments, closing):
            _serve(service, hub, arguments, settings, wire, closing)
            settings = _next(settings)
        service.run(stop)
    return 0


def _check_time(hub: Hub) -> None:
    """Raise WrongState for a lockstep hub without a pace: a dongle's host waits by the computer's clock."""
    if hub.time == "lockstep" and not hub.time_state().pace:
        raise WrongState(
            "a host of a serial dongle cannot take part in one time with other programs: hold the hub's time to the "
            "clock (`canwire pace 1`, serve --pace 1), or let the host use python-can's interface canwire"
        )


def _serve(
    service: Service,
    hub: Hub,
    arguments: argparse.Namespace,
    settings: Settings,
    wire: Wire,
    closing: ExitStack,
) -> None:
    """Plug in a dongle, serve it on this wire, and print where it is."""
    store = FileEeprom(Path(canwire.state_directory()) / f"{settings.serial_number}.eeprom")
    plugged = PluggedDongle(hub, settings, arguments.bus, store)
    closing.callback(plugged.close)
    name = f"{settings.serial_number} ({plugged.board.hardware_id} on {arguments.bus})"
    if arguments.verbose:
        plugged.dongle.on_change = lambda what: complain(f"{name}: {what}")
    closing.callback(_tell_losses, plugged.dongle.counters, name)
    service.add(plugged.dongle, plugged.event, wire, baud_rate=arguments.pace)
    print(f"canwire: {settings.dialect.name} dongle {name} at {wire.name}", flush=True)


def _tell_losses(counters: DongleCounters, name: str) -> None:
    if counters.losses:
        complain(f"{name}: {counters.summary}")


def _wires(arguments: argparse.Namespace, closing: ExitStack) -> list[Wire]:
    makers: list[Callable[[], Wire]] = [
        *(partial(PtyWire, link) for link in arguments.pty),
        *(partial(TcpWire, address, arguments.greeting_seconds) for address in arguments.tcp),
        *(partial(SerialWire, device, arguments.baud_rate) for device in arguments.serial),
    ]
    wires = []
    for make in makers or [_free_link]:
        wires.append(make())
        closing.callback(wires[-1].close)
    return wires


def _free_link() -> PtyWire:
    home = canwire.state_directory()
    for k in range(_MOST_LINKS):
        with suppress(InUse):
            try:
                return PtyWire(f"{home}/ttyCANBUS{k}")
            except OSError as error:
                raise BadValue(
                    f"{home}: {error.strerror or error}, so the terminal's link cannot be made there; name another "
                    "place by --pty PATH, or set XDG_STATE_HOME"
                ) from error
    raise InUse(f"{home}/ttyCANBUS0 to {_MOST_LINKS - 1}: all in use")


def _settings(arguments: argparse.Namespace) -> Settings:
    dialect = DIALECTS[arguments.dialect]
    return Settings(arguments.serial_number, arguments.version, arguments.tx_reply, dialect)


def _next(settings: Settings) -> Settings:
    """Return the settings with the next serial number, A124 after A123; unchanged if there is none."""
    head = settings.serial_number.rstrip("0123456789")
    digits = settings.serial_number[len(head) :]
    if not digits or set(digits) == {"9"}:
        return settings
    return replace(settings, serial_number=f"{head}{int(digits) + 1:0{len(digits)}}")
