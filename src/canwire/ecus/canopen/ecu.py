"""A small ECU with CANopen: canopen's LocalNode with the behaviour of a device.

Source: CiA 301 4.2.0, 7.3.2 (states), 7.5.2 (the objects of the communication profile).
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from canopen import LocalNode, Network, ObjectDictionary, SdoAbortedError

from canwire import LabNode
from canwire.ecus.bench import LabCondition
from canwire.ecus.canopen.dictionary import dictionary_of
from canwire.ecus.canopen.lss import ANSWERS, REQUESTS, LssSlave
from canwire.ecus.canopen.network import LabCanopen
from canwire.ecus.canopen.pdos import Pdos
from canwire.ecus.canopen.services import RESET_NODE, Emergencies, Nmt, Sdo, number_at

_SYNC, _EMERGENCY, _ERRORS = 0x1005, 0x1014, 0x1003
_IDENTITY = 0x1018
_COMMUNICATION = range(0x1000, 0x2000)  # what resetting the communication takes back
_USUAL_SYNC = 0x80
_NO_VALUE = 0x06090030  # an SDO abort code: not in the range of the object's values


class CanopenEcu(LocalNode):  # type: ignore[misc]
    """`bus.node("io", CanopenEcu(5))` in the lab, `network.create_node(CanopenEcu(5))` on a connected canopen.Network.

    `dictionary` is one of canopen, or the path of an EDS file (with the limits of `load_eds`); the default is a small
    I/O module, of EDS file `CanopenEcu.EDS`. It boots immediately. Its SDO server (also for blocks), heartbeats, TPDOs
    (on change, by event timer, on SYNC), RPDOs and emergencies follow the dictionary; a reset restores the
    dictionary's values.

    All members of a LocalNode are available: `sdo["Label"].raw` reads and writes the dictionary from inside, and can
    cause a TPDO on change; `nmt.state`, `emcy.send(...)`, `add_read_callback`, `add_write_callback`. `lss` answers LSS
    requests; a new node-ID takes effect at the next reset. Not supported: inhibit times, transmission on remote frames
    (types 252, 253).
    """

    EDS = str(Path(__file__).with_name("small.eds"))
    id: int

    def __init__(self, id: int = 1, dictionary: ObjectDictionary | str | Path | None = None) -> None:
        if dictionary is None:
            dictionary = self.EDS
        if isinstance(dictionary, str | Path):
            dictionary = dictionary_of(dictionary, id)
        super().__init__(id, dictionary)
        self.sdo = Sdo(self)
        self.nmt = Nmt(self.id, self, self._reset, self._entered)
        self.emcy = Emergencies(self)
        self._write_callbacks[:] = [self.nmt.on_write]  # in the place of LocalNode's
        self.pdos = Pdos(self)
        self.lss = LssSlave(self._numbers, self.id)
        self.resets = 0
        self._sync = 0
        # the network's thread and its owner's meet here
        self._changing: AbstractContextManager[Any] = threading.RLock()

    def run_on(self, node: LabNode) -> None:
        """Start on this node; `bus.node` does it."""
        self._changing = LabCondition(node)  # holds time still, as its bus does while this is called
        for pdo in (*self.tpdo.map.values(), *self.rpdo.map.values()):
            pdo.receive_condition = LabCondition(node)
        LabCanopen(node).create_node(self)

    def associate_network(self, network: Network) -> None:
        """Boot; `network.create_node` calls it. Raises canopen's RuntimeError if it is not connected."""
        super().associate_network(network)
        network.subscribe(REQUESTS, self._on_lss)
        try:
            self._boot()
        except BaseException:
            self.remove_network()
            raise

    def remove_network(self) -> None:
        """Leave the network."""
        if not self.has_network():
            return
        with self._changing:
            self.nmt.stop_heartbeat()
            self.pdos.end()
            self._listen_for_sync(0)
            self.network.unsubscribe(REQUESTS, self._on_lss)
            super().remove_network()

    def set_data(self, index: int, subindex: int, data: bytes, check_writable: bool = False) -> None:
        """Set the value of an object, with all effects; `check_writable` is for accesses from the bus."""
        if (index, subindex) == (_ERRORS, 0) and check_writable and any(data):
            raise SdoAbortedError(_NO_VALUE)  # 0 forgets the errors
        with self._changing:
            super().set_data(index, subindex, data, check_writable)
            if (index, subindex) == (_ERRORS, 0) and check_writable:
                self.data_store[_ERRORS] = {0: bytes(data)}
            if self.has_network():
                self._follow(index, subindex, data)

    def __repr__(self) -> str:
        return f"<CANopen ECU {self.id}: {self.nmt.state}, {self.resets} resets>"

    def _follow(self, index: int, subindex: int, data: bytes) -> None:
        if index == _SYNC:
            self._listen_for_sync(int.from_bytes(data, "little") & 0x1FFF_FFFF)
        elif index == _EMERGENCY:
            self.emcy.set_cob_id(int.from_bytes(data, "little"))
        self.pdos.written(index, subindex)

    def _reset(self, code: int) -> None:
        with self._changing:
            self.resets += 1
            self.nmt.stop_heartbeat()
            self.pdos.end()
            for index in list(self.data_store):
                if code == RESET_NODE or index in _COMMUNICATION:
                    del self.data_store[index]
            if code == RESET_NODE:
                self.lss.pending = self.lss.stored
            self._become(self.lss.pending)
            self._boot()

    def _become(self, id: int) -> None:
        """Set this node-ID, and the identifiers that depend on it."""
        if id == self.id:
            return
        network, before = self.network, self.id
        network.unsubscribe(self.sdo.rx_cobid, self.sdo.on_request)
        self.id = self.lss.id = self.nmt.id = id
        self.sdo.rx_cobid, self.sdo.tx_cobid = 0x600 + id, 0x580 + id
        network.subscribe(self.sdo.rx_cobid, self.sdo.on_request)
        for var in _variables(self.object_dictionary):
            if var.relative and var.default is not None:
                var.default += id - before
        if network.nodes.get(before) is self:
            network.nodes[id] = network.nodes.pop(before)

    def _numbers(self) -> list[int]:
        """Return vendor, product, revision and serial numbers."""
        found = (self.get_data(_IDENTITY, place) if self._has(place) else b"" for place in range(1, 5))
        return [int.from_bytes(one, "little") for one in found]

    def _has(self, place: int) -> bool:
        return _IDENTITY in self.object_dictionary and place in self.object_dictionary[_IDENTITY]

    def _on_lss(self, can_id: int, data: bytearray, timestamp: float) -> None:
        if len(data) == 8:
            with self._changing:
                answer = self.lss.answer(bytes(data))
                if answer is not None:
                    self.network.send_message(ANSWERS, answer)

    def _boot(self) -> None:
        self.sdo.forget()
        self.emcy.set_cob_id(number_at(self, _EMERGENCY, 0x80 + self.id))
        self._listen_for_sync(number_at(self, _SYNC, _USUAL_SYNC) & 0x1FFF_FFFF)
        self.nmt.boot()

    def _entered(self) -> None:
        with self._changing:
            operational = self.nmt.state == "OPERATIONAL"
            if operational and not self.pdos.running:
                self.pdos.begin()
            elif not operational and self.pdos.running:
                self.pdos.end()

    def _listen_for_sync(self, cob_id: int) -> None:
        """Listen for SYNC at `cob_id` instead of the previous identifier; 0: do not listen."""
        if self._sync:
            self.network.unsubscribe(self._sync, self._on_sync)
        self._sync = cob_id
        if cob_id:
            self.network.subscribe(cob_id, self._on_sync)

    def _on_sync(self, can_id: int, data: bytearray, timestamp: float) -> None:
        with self._changing:
            self.pdos.on_sync()


def _variables(dictionary: ObjectDictionary) -> Iterator[Any]:
    """All variables, including those of records and arrays."""
    for entry in dictionary.values():
        yield from entry.values() if hasattr(entry, "subindices") else (entry,)
