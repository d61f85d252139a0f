"""Process data of an ECU: PDOs between its dictionary and the bus, as objects 1400h to 1BFFh define them.

Source: CiA 301 4.2.0, 7.2.2; transmission types in 7.5.2.35 and 7.5.2.37.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator

from canopen import LocalNode, SdoAbortedError
from canopen.pdo import PdoMap, PdoVariable

_LOG = logging.getLogger(__name__)
_ON_CHANGE, _SYNC_MOST, _SYNC_IF_CHANGED = 254, 240, 0
_LENGTH_ERROR, _COMMUNICATION = 0x8210, 1 << 4  # an emergency's code, and the error register's bit
_MOST_BITS = 64
_COM_RX, _MAP_RX, _COM_TX, _MAP_TX, _END = 0x1400, 0x1600, 0x1800, 0x1A00, 0x1C00


class Pdos:
    """The PDOs of `node`, which calls `begin` when it enters the state operational, and `end` when it leaves it.

    `short` counts RPDOs with too few bytes."""

    def __init__(self, node: LocalNode) -> None:
        self.running = False
        self.short = 0
        self._node = node
        self._syncs = 0
        self._due: set[int] = set()  # of those on SYNC: TPDOs that changed, RPDOs that came; by id()
        for pdo in node.rpdo.map.values():
            pdo.add_callback(self._received)

    def begin(self) -> None:
        """Start the PDOs of an operational node: send TPDOs on change once, and repeatedly if they
        have an event timer."""
        self.running, self._syncs = True, 0
        self._due.clear()
        for pdo in self._node.rpdo.map.values():
            _read(pdo)
        for pdo in self._node.tpdo.map.values():
            self._set_up(pdo)

    def end(self) -> None:
        """Stop all PDOs."""
        self.running = False
        for pdo in self._node.tpdo.map.values():
            pdo.stop()

    def written(self, index: int, subindex: int) -> None:
        """Handle the writing of an object, whose value may have changed."""
        if not self.running:
            return
        if _COM_RX <= index < _END:
            self._changed_parameter(index)
            return
        for pdo in self._transmitted():
            if any((var.index, var.subindex) == (index, subindex) for var in pdo.map) and self._stale(pdo):
                self._due.add(id(pdo))
                if pdo.trans_type >= _ON_CHANGE:
                    self._send(pdo)

    def on_sync(self) -> None:
        """Handle a SYNC: TPDOs copy the dictionary's values, then RPDOs received since the last SYNC change them."""
        if not self.running:
            return
        self._syncs += 1
        for pdo in self._transmitted():
            kind = pdo.trans_type
            due = id(pdo) in self._due if kind == _SYNC_IF_CHANGED else not self._syncs % kind
            if kind <= _SYNC_MOST and due:
                self._send(pdo)
        for pdo in self._node.rpdo.map.values():
            if id(pdo) in self._due:
                self._due.discard(id(pdo))
                self._apply(pdo)

    def _transmitted(self) -> Iterator[PdoMap]:
        return (pdo for pdo in self._node.tpdo.map.values() if pdo.enabled and pdo.map)

    def _changed_parameter(self, index: int) -> None:
        transmits = index >= _COM_TX
        base = (_MAP_TX if index >= _MAP_TX else _COM_TX) if transmits else _COM_RX
        base = _MAP_RX if _MAP_RX <= index < _COM_TX else base
        pdos = self._node.tpdo.map if transmits else self._node.rpdo.map
        pdo = pdos.maps.get(index - base + 1)
        if pdo is not None and transmits:
            self._set_up(pdo)
        elif pdo is not None:
            _read(pdo)

    def _set_up(self, pdo: PdoMap) -> None:
        pdo.stop()
        _read(pdo)
        if not pdo.enabled:
            return
        self._node.network.unsubscribe(pdo.cob_id, pdo.on_message)  # it is sent here
        self._due.add(id(pdo))
        if pdo.trans_type >= _ON_CHANGE and pdo.map:
            self._send(pdo)

    def _send(self, pdo: PdoMap) -> None:
        """Send the dictionary's current values, and restart the event timer."""
        pdo.stop()
        self._due.discard(id(pdo))
        for var in pdo.map:
            var.set_data(self._value(var))
        if pdo.trans_type >= _ON_CHANGE and pdo.event_timer:
            pdo.start(pdo.event_timer / 1000)
        else:
            pdo.transmit()

    def _stale(self, pdo: PdoMap) -> bool:
        return any(var.get_data() != self._value(var) for var in pdo.map)

    def _value(self, var: PdoVariable) -> bytes:
        """Return the dictionary's value of the object; zeros until a value is set."""
        try:
            return bytes(self._node.get_data(var.index, var.subindex))
        except SdoAbortedError:
            return bytes(len(var.od) // 8)

    def _received(self, pdo: PdoMap) -> None:
        if not self.running or not pdo.enabled:
            return
        if 8 * len(pdo.data) < pdo.length:
            self.short += 1
            self._node.emcy.send(_LENGTH_ERROR, _COMMUNICATION)
        elif pdo.trans_type <= _SYNC_MOST:
            self._due.add(id(pdo))
        else:
            self._apply(pdo)

    def _apply(self, pdo: PdoMap) -> None:
        for var in pdo.map:
            self._node.set_data(var.index, var.subindex, var.get_data())


def _read(pdo: PdoMap) -> None:
    """Read the PDO's definition from the dictionary; an incomplete or impossible PDO is disabled."""
    trouble = ""
    try:
        pdo.read()
    except (KeyError, SdoAbortedError) as error:
        trouble = str(error)
    if pdo.length > _MOST_BITS or any(var.length > len(var.od) for var in pdo.map):
        trouble = f"{pdo.length} bits are mapped, or more of an object than it has"
    if trouble:
        pdo.enabled = False
        _LOG.warning("%s is off: %s", pdo.com_record.od.name, trouble)
