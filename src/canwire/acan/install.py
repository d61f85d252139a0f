"""Which board the driver serves: ACAN.EXE got it with /P and /I, VACAND.386 from SYSTEM.INI.

The hub stores it in its note "acan"; an empty note means any board (`find_line`).
Source: INduCAN104 manual, "Drivers and utilities setup"; the scripts are for a Unix shell instead of START.BAT.
"""

from __future__ import annotations

import configparser
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Self

from canwire import BadText, BadValue, InUse, NoSuchBoard

if TYPE_CHECKING:
    import os

    from canwire import BoardInfo, Hub

KIND = "inducan104"
NOTE = "acan"
UNINSTALLED = b"uninstalled"
FIRST_PORT, LAST_PORT, PORT_STEP = 0x100, 0x3E0, 0x20
IRQS = (3, 4, 5, 7, 9, 10, 11)
_SJA1000 = 5  # CAN_CTRL_SJA1000 (reference/vci.md section 3)
_PORT = re.compile(r"/P:([0-9A-F]{1,4})H?", re.IGNORECASE)
_IRQ = re.compile(r"/I:([0-9]{1,2})(\*?)", re.IGNORECASE)
_WRITTEN = re.compile(rb"([0-9A-F]{3}):([0-9]{1,2})(\*?)")
_SECTION = "ACAN"
START, STOP, INI, WORLD = "START", "STOP", "acan.ini", "canwire.toml"
_PID, _LOG = "hub.pid", "hub.log"  # START writes them into its own directory
SERIAL = "HW000104"  # of the board in canwire.toml


class DriverAbsent(NoSuchBoard):
    """The ACAN driver is not operational: it is uninstalled, or no board has the jumpers it was installed with."""


@dataclass(frozen=True, slots=True)
class Installation:
    """The jumpers of the board to serve: base address 100h..3E0h in steps of 20h, interrupt 3, 4, 5, 7, 9, 10 or 11.

    `shared` allows other devices to use the same interrupt; the driver stores it and does not use it.
    Raises BadValue.
    """

    port: int = 0x280
    irq: int = 5
    shared: bool = False

    def __post_init__(self) -> None:
        fits = isinstance(self.port, int) and FIRST_PORT <= self.port <= LAST_PORT
        if not fits or self.port % PORT_STEP:
            shown = f"{self.port:X}h" if isinstance(self.port, int) else repr(self.port)
            raise BadValue(f"port {shown}: 100h to 3E0h in steps of 20h")
        if self.irq not in IRQS:
            raise BadValue(f"irq {self.irq!r}: one of {', '.join(map(str, IRQS))}")

    @classmethod
    def parse(cls, arguments: str | Iterable[str]) -> Self | None:
        """Parses ACAN's command line `/P:280 /I:5` or `/I:5*`, one text or its words; None for `/U`. Raises BadText."""
        text = arguments if isinstance(arguments, str) else " ".join(arguments)
        words = text.replace("/", " /").split()
        if [word.upper() for word in words] == ["/U"]:
            return None
        ports = [found for word in words if (found := _PORT.fullmatch(word))]
        irqs = [found for word in words if (found := _IRQ.fullmatch(word))]
        if len(words) != 2 or len(ports) != 1 or len(irqs) != 1:
            raise BadText(
                f"{text!r}: write /P:<port> /I:<irq>[*] or /U, the port in hexadecimal, the irq in decimal"
            )
        return cls(int(ports[0][1], 16), int(irqs[0][1]), irqs[0][2] == "*")

    @classmethod
    def from_ini(cls, text: str) -> Self:
        """Reads `Base=` (hexadecimal) and `Irq=` of section [ACAN]; raises BadText, BadValue."""
        parser = configparser.ConfigParser(strict=False, allow_no_value=True, interpolation=None)
        try:
            parser.read_string(text)
            section = parser[_SECTION]
            base, irq = section["Base"].strip(), section["Irq"].strip()
            return cls(int(base.rstrip("hH"), 16), int(irq.rstrip("*")), irq.endswith("*"))
        except (configparser.Error, KeyError, AttributeError, TypeError) as error:
            raise BadText(f"no section [{_SECTION}] with Base= and Irq=: {error}") from None
        except BadValue:
            raise
        except ValueError:
            raise BadText(f"[{_SECTION}] Base={base} Irq={irq}: a hexadecimal and a decimal number") from None

    def to_ini(self) -> str:
        """The section for SYSTEM.INI."""
        return f"[{_SECTION}]\nBase={self.port:X}\nIrq={self.irq}{'*' * self.shared}\n"

    def to_arguments(self) -> str:
        return f"/P:{self.port:X} /I:{self.irq}{'*' * self.shared}"

    def to_note(self) -> bytes:
        return f"{self.port:X}:{self.irq}{'*' * self.shared}".encode("ascii")

    @classmethod
    def from_note(cls, note: bytes) -> Self:
        """Parses the result of `to_note`; raises BadText."""
        found = _WRITTEN.fullmatch(note)
        if found is None:
            raise BadText(f"note {NOTE!r} {note!r}: <port>:<irq>")
        return cls(int(found[1], 16), int(found[2]), found[3] == b"*")

    def serves(self, board: BoardInfo) -> bool:
        """Whether the board has these jumpers."""
        there = dict(board.resources)
        return there.get("I/O", "").startswith(f"{self.port:X}h") and there.get("IRQ") == str(self.irq)


def find_line(hub: Hub, name: str | None = None) -> tuple[BoardInfo, int]:
    """The board that the driver serves, and the number of its line.

    With `name` it is that board (see `Hub.board`), otherwise the installed one; without an installation it is the
    first INduCAN104, else the first board with an SJA1000. Raises DriverAbsent, and NoSuchBoard for a wrong `name`.
    """
    note = hub.note(NOTE) if name is None else b""
    boards = hub.boards() if name is None else (hub.board(name),)
    if note == UNINSTALLED:
        raise DriverAbsent("the ACAN driver was uninstalled; install it with /P and /I")
    if note:
        wanted = Installation.from_note(note)
        return _answering(boards, wanted), 0
    lines = [
        (board.kind != KIND, board, number)
        for board in boards
        for number, line in enumerate(board.lines)
        if line.bus_type == "CAN" and line.capabilities.controller_type == _SJA1000
    ]
    if not lines:
        there = ", ".join(f"{board.hardware_id} ({board.kind})" for board in boards) or "none"
        raise DriverAbsent(f"no board with an SJA1000 for ACAN; plugged in: {there}")
    _, board, number = min(lines, key=lambda found: found[0])
    return board, number


def install(hub: Hub, installation: Installation) -> BoardInfo:
    """Serve the board with these jumpers from now on, in each program that opens the driver.

    Its controller is off the bus afterwards. Raises DriverAbsent if no board has these jumpers, InUse if the driver
    serves another board or a program holds the control of the line.
    """
    note = hub.note(NOTE)
    if note not in (b"", UNINSTALLED, installation.to_note()):
        raise InUse(f"the ACAN driver is installed for {note.decode('ascii', 'replace')}; uninstall it first")
    board = _answering(hub.boards(), installation)
    _leave_bus(hub, board, 0)
    hub.set_note(NOTE, installation.to_note())
    return board


def uninstall(hub: Hub) -> None:
    """Uninstall the driver; its line leaves the bus and loses its configuration. A second call does nothing.

    Raises InUse while programs use the line.
    """
    if hub.note(NOTE) == UNINSTALLED:
        return
    try:
        board, number = find_line(hub)
    except DriverAbsent:
        hub.set_note(NOTE, UNINSTALLED)
        return
    users = hub.line_status(board.id, number).channels
    if users:
        raise InUse(f"{board.hardware_id}: {users} programs use it; end them first")
    with hub.open_control(board.id, number) as control:
        control.reset()
    hub.set_note(NOTE, UNINSTALLED)


def setup(port: int, irq: int, directory: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Write START, STOP, acan.ini and canwire.toml for a board with these jumpers; returns the four paths.

    It makes the directory if necessary and replaces files with these names. Raises BadValue.
    """
    installation = Installation(port, irq)
    home = Path(directory)
    home.mkdir(parents=True, exist_ok=True)
    texts = {
        START: _start(installation),
        STOP: _stop(),
        INI: installation.to_ini(),
        WORLD: _world(installation),
    }
    for name, text in texts.items():
        path = home / name
        path.write_text(text, encoding="utf-8", newline="\n")
        path.chmod(0o755 if name in (START, STOP) else 0o644)
    return tuple(home / name for name in texts)


def _answering(boards: tuple[BoardInfo, ...], wanted: Installation) -> BoardInfo:
    for board in boards:
        if board.kind == KIND and wanted.serves(board):
            return board
    there = [
        f"{board.hardware_id} at {' '.join(value for _, value in board.resources)}"
        for board in boards
        if board.kind == KIND
    ]
    raise DriverAbsent(
        f"no controller answers at {wanted.port:X}h with IRQ {wanted.irq}; there: {', '.join(there) or 'none'}"
    )


def _leave_bus(hub: Hub, board: BoardInfo, number: int) -> None:
    if hub.line_status(board.id, number).running:
        with hub.open_control(board.id, number) as control:
            control.stop()


def _start(installation: Installation) -> str:
    """The script START: it starts a hub, in place of ADTM, unless one runs already, and installs the driver."""
    return f"""#!/bin/sh
cd "$(dirname "$0")" || exit
if ! kill -0 "$(cat {_PID} 2> /dev/null)" 2> /dev/null; then
    nohup canwire serve ${{CANWIRE_HUB:+--socket "$CANWIRE_HUB"}} --config {WORLD} > {_LOG} 2>&1 &
    echo $! > {_PID}
    for second in 1 2 3 4 5 6 7 8 9 10; do
        kill -0 "$(cat {_PID})" 2> /dev/null || rm -f {_PID}
        [ -f {_PID} ] || break
        grep -q "canwire hub on" {_LOG} 2> /dev/null && break
        sleep 1
    done
fi
exec canwire acan install {installation.to_arguments()}
"""


def _stop() -> str:
    """The script STOP: it uninstalls the driver, and ends the hub if START started that."""
    return f"""#!/bin/sh
cd "$(dirname "$0")" || exit
if ! canwire acan install /U; then
    [ -f {_PID} ] && ! kill -0 "$(cat {_PID})" 2> /dev/null && rm -f {_PID} {_LOG}
    exit 2
fi
[ -f {_PID} ] && kill "$(cat {_PID})" 2> /dev/null
rm -f {_PID} {_LOG}
"""


def _world(installation: Installation) -> str:
    return (
        '[[bus]]\nname = "can0"\n\n'
        f'[[board]]\nkind = "inducan104"\nserial = "{SERIAL}"\n'
        f"base = 0x{installation.port:X}\nirq = {installation.irq}\n"
    )
