"""A small ECU with J1939: can-j1939's ControllerApplication with the behaviour of a device.

Source: SAE J1939-21 5.4.2 (requests), 5.4.4 (acknowledgment); J1939-73 5.7.1 (DM1); J1939-81 4 (addresses).
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any

from j1939 import ControllerApplication, Dm1, ElectronicControlUnit, Name

from canwire import BadValue, LabNode
from canwire.ecus.bench import LabCondition
from canwire.ecus.j1939.unit import LabJ1939

GLOBAL = 0xFF
_ACKNOWLEDGMENT, _NEGATIVE = 0xE800, 1
_PRIORITY = 6
_RETRY_S = 0.05  # a message to the same destination is on its way: look again
_DM1_S = 1.0
_MOST = 1785  # bytes that the transport protocol carries
_LAST = 0x1FFFF  # parameter group: a data page, a format, an extension
_STATES = {0: "not started", 1: "claiming", 2: "claimed", 3: "cannot claim"}

Content = bytes | Callable[[], bytes]


class Application(ControllerApplication):  # type: ignore[misc]
    """A ControllerApplication whose timers pause while it has no address."""

    def add_timer(self, delta_time: float, callback: Callable[[Any], Any], cookie: Any = None) -> None:
        def turn(cookie: Any) -> Any:
            return callback(cookie) if self.state == self.State.NORMAL else True

        super().add_timer(delta_time, turn, cookie)


class J1939Ecu:
    """`bus.node("engine", J1939Ecu(0x80))` in the lab, `J1939Ecu(0x80).start(unit)` on a connected unit of can-j1939.

    It claims `address` half a second later. If an ECU with a lower name claims the same address, this one moves to the
    next address if its `name` (of can-j1939) is arbitrary_address_capable; otherwise it has no address. `groups` are
    its parameter groups by number (PGN): up to 1785 bytes, or a function that returns them. Requests for them are
    answered; requests to this ECU for other groups get a negative acknowledgment. Groups in `cycles` are also sent
    periodically, with these periods in seconds. `on_message(pgn, source, data)` gets the messages of other ECUs, of one
    frame or several. `set_faults` starts DM1, which is sent each second.

    Groups from 0xF000 on are sent to all nodes, also in response to one node's request: can-j1939 cannot do otherwise.
    """

    def __init__(
        self,
        address: int = 0x80,
        *,
        name: Name | None = None,
        groups: Mapping[int, Content] | None = None,
        cycles: Mapping[int, float] | None = None,
        on_message: Callable[[int, int, bytes], None] | None = None,
    ) -> None:
        if not 0 <= address <= 253:
            raise BadValue(f"address {address!r}: 0 to 253")
        self.groups = dict(groups or {})
        self.cycles = dict(cycles or {})
        for pgn, content in self.groups.items():
            _check(pgn, b"" if callable(content) else content)
        for pgn in self.cycles:
            if pgn not in self.groups:
                raise BadValue(f"cycles: parameter group {pgn:#06x} is not among the groups")
        self.name = name or Name(arbitrary_address_capable=1, identity_number=1)
        self.application = Application(self.name, address)
        self._on_message = on_message
        self._waiting: deque[tuple[int, bytes, int, int]] = deque()
        self._faults: list[dict[str, int]] = []
        self._lamps: dict[str, int] = {}
        # the unit's two threads and its owner's meet here
        self._sending: AbstractContextManager[Any] = threading.RLock()

    def run_on(self, node: LabNode) -> None:
        """Start on this node; `bus.node` does it."""
        self._sending = LabCondition(node)  # holds time still, as its bus does while this is called
        self.start(LabJ1939(node))

    def start(self, unit: ElectronicControlUnit) -> None:
        """Start on `unit`, which must be connected."""
        application = self.application
        unit.add_ca(controller_application=application)
        application.subscribe(self._heard)
        application.subscribe_request(self._asked)
        for pgn, period in self.cycles.items():
            application.add_timer(period, self._cycle, pgn)
        application.start()

    @property
    def address(self) -> int | None:
        """The address; None while the ECU has none."""
        return int(self.application.device_address) if self.state == "claimed" else None

    @property
    def state(self) -> str:
        """ "not started", "claiming", "claimed" or "cannot claim"."""
        return _STATES[self.application.state]

    def send(self, pgn: int, data: bytes, destination: int = GLOBAL, priority: int = _PRIORITY) -> None:
        """Send a message: one frame, or for more than 8 bytes by BAM to all nodes, by RTS and CTS to one node.

        It waits until another long message to the same destination has ended. Raises BadValue for more than 1785 bytes,
        and can-j1939's RuntimeError while the ECU has no address.
        """
        _check(pgn, data)
        message = pgn, bytes(data), destination, priority
        with self._sending:
            if self._waiting or not self._send(*message):
                self._waiting.append(message)
                if len(self._waiting) == 1:
                    self.application.add_timer(_RETRY_S, self._retry)

    def set_faults(self, faults: Sequence[Mapping[str, int]], lamps: Mapping[str, int] | None = None) -> None:
        """Start DM1: each fault has `spn`, `fmi` and optionally `oc`; the lamps are `pl`, `awl`, `rsl`, `mil`
        (j1939.DtcLamp)."""
        begun = bool(self._faults or self._lamps)
        self._faults, self._lamps = [dict(fault) for fault in faults], dict(lamps or {})
        if not begun:
            Dm1(self.application).start_send(lambda: (dict(self._lamps), list(self._faults)), _DM1_S)

    def __repr__(self) -> str:
        where = "no address" if self.address is None else f"address {self.address:#04x}"
        return f"<J1939 ECU {self.name.value:#018x}: {self.state}, {where}>"

    def _send(self, pgn: int, data: bytes, destination: int, priority: int) -> bool:
        page, format, specific = pgn >> 16 & 1, pgn >> 8 & 0xFF, pgn & 0xFF
        to = destination if format < 240 else specific
        return bool(self.application.send_pgn(page, format, to, priority, list(data)))

    def _retry(self, _: Any) -> bool:
        with self._sending:
            while self._waiting and self._send(*self._waiting[0]):
                self._waiting.popleft()
            return bool(self._waiting)

    def _content(self, pgn: int) -> bytes:
        content = self.groups[pgn]
        return content() if callable(content) else content

    def _cycle(self, pgn: int) -> bool:
        self.send(pgn, self._content(pgn))
        return True

    def _asked(self, source: int, destination: int, pgn: int) -> None:
        if pgn in self.groups:
            self.send(pgn, self._content(pgn), GLOBAL if destination == GLOBAL else source)
        elif destination != GLOBAL:
            refusal = bytes([_NEGATIVE, 0xFF, 0xFF, 0xFF, source]) + pgn.to_bytes(3, "little")
            self.send(_ACKNOWLEDGMENT, refusal)

    def _heard(self, priority: int, pgn: int, source: int, timestamp: float, data: Any) -> None:
        if self._on_message is not None:
            addressed = pgn >> 8 & 0xFF < 240  # their low byte is a destination, or 0
            self._on_message(pgn & ~0xFF if addressed else pgn, source, bytes(data))


def _check(pgn: int, data: bytes) -> None:
    if not 0 <= pgn <= _LAST:
        raise BadValue(f"parameter group {pgn:#06x}: up to {_LAST:#x}")
    if len(data) > _MOST:
        raise BadValue(f"parameter group {pgn:#06x}: {len(data)} bytes; {_MOST} fit")
