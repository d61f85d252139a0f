"""The CANopen services of an ECU, where canopen's local ones leave the behaviour of a device open.

Source: CiA 301 4.2.0, 7.2.4 (SDO), 7.2.7 (EMCY), 7.2.8 (NMT), 7.3.2 (state machine).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from canopen import LocalNode, SdoAbortedError
from canopen.emcy import EmcyProducer
from canopen.nmt import NmtBase, NmtSlave
from canopen.sdo import SdoServer

from canwire.ecus.canopen.blocks import BlockDownload, BlockUpload

RESET_NODE, RESET_COMMUNICATION = 129, 130
_PRE_OPERATIONAL = 128
_HEARTBEAT = 0x1017
_ERROR_REGISTER, _ERRORS = 0x1001, 0x1003
_NOT_VALID = 1 << 31
_PATIENCE_S = 1.0  # with which a block transfer waits for its client; CiA 301 leaves it to the device
_ABORTED, _CRC, _SIZED = 0x80, 0x04, 0x02  # of an SDO request
TALKING = ("PRE-OPERATIONAL", "OPERATIONAL")


def number_at(node: LocalNode, index: int, otherwise: int) -> int:
    """An object's value; `otherwise` if the dictionary has none."""
    try:
        return int.from_bytes(node.get_data(index, 0), "little")
    except SdoAbortedError:
        return otherwise


class Nmt(NmtSlave):  # type: ignore[misc]
    """The NMT slave. A reset calls `reset(code)`; other changes of state call `entered()` at their end."""

    def __init__(
        self, id: int, node: LocalNode, reset: Callable[[int], None], entered: Callable[[], None]
    ) -> None:
        super().__init__(id, node)
        self._reset = reset
        self._entered = entered

    def on_command(self, can_id: int, data: bytearray, timestamp: float) -> None:
        if len(data) != 2 or data[1] not in (0, self.id):
            return
        if data[0] in (RESET_NODE, RESET_COMMUNICATION):
            self._reset(data[0])
        else:
            super().on_command(can_id, data, timestamp)
            self._entered()

    def send_command(self, code: int) -> None:
        if code in (RESET_NODE, RESET_COMMUNICATION):
            self._reset(code)
        else:
            super().send_command(code)
            self._entered()

    def boot(self) -> None:
        """Send the boot-up message; pre-operational from then on, with heartbeats if the dictionary enables them."""
        super().send_command(RESET_NODE)
        if number_at(self._local_node, _HEARTBEAT, 0):
            super().send_command(_PRE_OPERATIONAL)
        else:
            NmtBase.send_command(self, _PRE_OPERATIONAL)


class Sdo(SdoServer):  # type: ignore[misc]
    """The SDO server of a node. It answers requests of 8 bytes while the node is pre-operational or operational.

    Block transfers are in `blocks.py`.
    """

    def __init__(self, node: LocalNode) -> None:
        super().__init__(0x600 + node.id, 0x580 + node.id, node)
        self._index = self._subindex = 0  # of an abort before any transfer
        self._block: BlockUpload | BlockDownload | None = None
        self._heard_s = 0.0

    def forget(self) -> None:
        """Discard the block transfer in progress."""
        self._block = None

    def on_request(self, can_id: int, data: bytearray, timestamp: float) -> None:
        if len(data) != 8 or self._node.nmt.state not in TALKING:
            return
        if timestamp - self._heard_s > _PATIENCE_S:
            self.forget()
        self._heard_s = timestamp
        if self._block is not None and data[0] != _ABORTED:
            self._go_on(bytes(data))
        else:
            self.forget()
            super().on_request(can_id, data, timestamp)

    def block_upload(self, data: bytearray) -> None:
        """Start a block upload that the client requests; a short object is sent without blocks if
        the client allows it."""
        self._index, self._subindex = int.from_bytes(data[1:3], "little"), data[3]
        found = self._node.get_data(self._index, self._subindex, check_readable=True)
        if len(found) <= data[5]:
            self.init_upload(data)
            return
        crc = bool(data[0] & _CRC)
        self._block = BlockUpload(bytes(found), bytes(data[1:4]), data[4], crc, self.send_response)

    def block_download(self, data: bytearray) -> None:
        """Start a block download, by which the client writes an object."""
        self._index, self._subindex = int.from_bytes(data[1:3], "little"), data[3]
        index, subindex = self._index, self._subindex
        size = int.from_bytes(data[4:8], "little") if data[0] & _SIZED else None
        self._block = BlockDownload(
            bytes(data[1:4]),
            size,
            bool(data[0] & _CRC),
            self.send_response,
            lambda whole: self._node.set_data(index, subindex, whole, check_writable=True),
        )

    def _go_on(self, data: bytes) -> None:
        assert self._block is not None
        try:
            if self._block.take(data):
                self._block = None
        except SdoAbortedError as error:
            self._block = None
            self.abort(error.code)


class Emergencies(EmcyProducer):  # type: ignore[misc]
    """Emergency messages, which are also kept in the dictionary's error register and list of errors, if it has them."""

    def __init__(self, node: LocalNode) -> None:
        super().__init__(0x80 + node.id)
        self.valid = True
        self._node = node

    def send(self, code: int, register: int = 0, data: bytes = b"") -> None:
        """Send an error: its code (16 bits), the new error register, and five manufacturer-specific bytes."""
        self._keep(code, register, data)
        if self._may():
            super().send(code, register, data)

    def reset(self, register: int = 0, data: bytes = b"") -> None:
        """Report that the error has ended."""
        self._keep(0, register, data)
        if self._may():
            super().reset(register, data)

    def set_cob_id(self, value: int) -> None:
        """Set the identifier and validity from a value of object 0x1014."""
        self.cob_id, self.valid = value & 0x1FFF_FFFF, not value & _NOT_VALID

    def _may(self) -> bool:
        return self.valid and self._node.nmt.state in TALKING

    def _keep(self, code: int, register: int, data: bytes) -> None:
        dictionary = self._node.object_dictionary
        if _ERROR_REGISTER in dictionary:
            self._node.set_data(_ERROR_REGISTER, 0, bytes([register]))
        if code and _ERRORS in dictionary:
            told: dict[int, Any] = self._node.data_store.get(_ERRORS, {})
            room = max(dictionary[_ERRORS], default=0)
            known = [told[place] for place in range(1, room + 1) if place in told]
            listed = [code.to_bytes(2, "little") + data[:2].ljust(2, b"\0"), *known][:room]
            for place, entry in enumerate(listed, 1):
                self._node.set_data(_ERRORS, place, entry)
            self._node.set_data(_ERRORS, 0, bytes([len(listed)]))
