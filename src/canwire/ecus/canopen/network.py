"""canopen's Network on a node of the lab: periodic messages and waits use the lab's time."""

from __future__ import annotations

from typing import Any
from weakref import WeakSet

from canopen import LocalNode, Network, ObjectDictionary, RemoteNode

from canwire import BadValue, Frame, LabNode
from canwire.ecus.bench import LabFrames, LabTask
from canwire.ecus.canopen.dictionary import dictionary_of
from canwire.ecus.canopen.remote import LabRemoteNode

_STANDARD = 0x7FF  # identifiers above are extended


class LabCanopen(Network):  # type: ignore[misc]
    """A network that is connected from its creation and receives all frames of `node`.

    `add_node` makes remote nodes whose SDO transfers and waits for heartbeats, PDOs and emergencies let the lab's time
    pass; `errors` are the exceptions that invalid frames have caused. `time.transmit` sends the wall clock's time.
    """

    def __init__(self, node: LabNode) -> None:
        super().__init__()
        self.node = node
        self._tasks: WeakSet[LabTask] = WeakSet()
        self._frames = LabFrames(node, self._take)

    @property
    def errors(self) -> list[Exception]:
        return self._frames.errors

    def connect(self, *_: Any, **__: Any) -> Network:
        """Raise BadValue: the network is already connected."""
        raise BadValue(f"this network is on {self.node.line.name} already")

    def disconnect(self) -> None:
        """Stop sending and receiving; the node stays on its bus."""
        for task in list(self._tasks):
            task.stop()
        self._frames.close()

    def add_node(
        self,
        node: int | RemoteNode | LocalNode,
        object_dictionary: str | ObjectDictionary | None = None,
        upload_eds: bool = False,
    ) -> RemoteNode:
        """Add a node; raises BadValue for `upload_eds`, which needs a network in the wall clock's time."""
        if upload_eds:
            raise BadValue("upload_eds: read object 0x1021 by a remote node, and give its text to import_od")
        if isinstance(node, int):
            if isinstance(object_dictionary, str):
                object_dictionary = dictionary_of(object_dictionary, node)
            node = LabRemoteNode(self.node, node, object_dictionary or ObjectDictionary())
        return super().add_node(node)

    def send_message(self, can_id: int, data: Any, remote: bool = False) -> None:
        """Queue a frame. Raises QueueFull, Closed."""
        self.node.send(_frame(can_id, data, remote))

    def send_periodic(self, can_id: int, data: Any, period: float, remote: bool = False) -> Any:
        """Send a frame immediately, and then periodically. The returned task has `stop` and `update`."""
        task = LabTask(self.node, _frame(can_id, data, remote), period)
        self._tasks.add(task)
        return task

    def __repr__(self) -> str:
        nodes = ", ".join(map(str, self.nodes)) or "none"
        return f"<CANopen on {self.node.line.name}: nodes {nodes}; {len(self.errors)} errors>"

    def _take(self, frame: Frame) -> None:
        if frame.extended == (frame.id > _STANDARD) and not frame.fd:
            self.notify(frame.id, bytearray(frame.data), (frame.timestamp_ns or 0) / 1e9)


def _frame(id: int, data: Any, remote: bool) -> Frame:
    return Frame(id, b"" if data is None else bytes(data), extended=id > _STANDARD, remote=remote)
