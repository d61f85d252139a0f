"""canopen's RemoteNode, with waits in the lab's time: for SDO responses, boot-ups, heartbeats, PDOs, emergencies."""

from __future__ import annotations

from canopen import ObjectDictionary, RemoteNode, SdoCommunicationError
from canopen.nmt import NmtError, NmtMaster
from canopen.sdo import SdoClient

from canwire import LabNode
from canwire.ecus.bench import LabCondition


class LabRemoteNode(RemoteNode):  # type: ignore[misc]
    """Created by `LabCanopen.add_node`, on the lab's `node`."""

    def __init__(self, node: LabNode, id: int, dictionary: ObjectDictionary | str) -> None:
        self._node = node
        super().__init__(id, dictionary)
        self.nmt = _LabNmt(node, self.id)
        self.emcy.emcy_received = LabCondition(node)
        for pdo in (*self.tpdo.map.values(), *self.rpdo.map.values()):
            pdo.receive_condition = LabCondition(node)

    def add_sdo(self, rx_cobid: int, tx_cobid: int) -> SdoClient:
        """Add an SDO client as in canopen."""
        client = _LabSdo(self._node, rx_cobid, tx_cobid, self.object_dictionary)
        self.sdo_channels.append(client)
        if self.has_network():
            self.network.subscribe(client.tx_cobid, client.on_response)
        return client


class _LabSdo(SdoClient):  # type: ignore[misc]
    """An SDO client whose RESPONSE_TIMEOUT counts the lab's time."""

    def __init__(self, node: LabNode, rx_cobid: int, tx_cobid: int, dictionary: ObjectDictionary) -> None:
        super().__init__(rx_cobid, tx_cobid, dictionary)
        self._time = node.time

    def on_response(self, can_id: int, data: bytearray, timestamp: float) -> None:
        super().on_response(can_id, data, timestamp)
        self._time.timeline.halt()

    def read_response(self) -> bytes:
        deadline_ns = self._time.now_ns + round(self.RESPONSE_TIMEOUT * 1e9)
        if not self._time.advance(deadline_ns, lambda: not self.responses.empty()):
            raise SdoCommunicationError("No SDO response received")
        return bytes(super().read_response())


class _LabNmt(NmtMaster):  # type: ignore[misc]
    """An NMT master whose waits use the lab's time."""

    def __init__(self, node: LabNode, id: int) -> None:
        super().__init__(id)
        self._time = node.time
        self.state_update = LabCondition(node)

    def wait_for_bootup(self, timeout: float = 10) -> None:
        """Wait for the boot-up message; raises NmtError after `timeout` seconds."""
        deadline_ns = self._time.now_ns + round(timeout * 1e9)
        self._state_received = None
        while self._state_received != 0:
            with self.state_update:
                left_s = (deadline_ns - self._time.now_ns) / 1e9
                if left_s <= 0 or not self.state_update.wait(left_s):
                    raise NmtError("Timeout waiting for boot-up message")
