"""The nodes that send a log's frames: one for each identifier, as in a car, up to what a bus can carry.

The work of a bus for a frame grows with its nodes. If a log has more identifiers than MOST (J1939's sessions, a
fuzzer's random ones), nodes are reused: each serves one identifier until its frames are sent, then another. The number
of nodes is that of identifiers with frames at the same time, POOL at most; frames that are due together arbitrate as
before.
"""

from __future__ import annotations

from collections.abc import Collection

from canwire import Frame, LabBus, LabNode, QueueFull

MOST, POOL = 256, 64
_QUEUE = 1024
Key = tuple[bool, int]  # extended, identifier


class Senders:
    """The sending nodes. With few identifiers all of them are on the bus before the first frame."""

    def __init__(self, bus: LabBus, keys: Collection[Key]) -> None:
        self._bus = bus
        self._free: list[LabNode] = []
        self._made = 0
        self._grows = len(keys) > MOST
        self._serving: dict[Key, LabNode] = {}
        if not self._grows:
            names = [f"{id:08X}" if extended else f"{id:03X}" for extended, id in keys]
            self._free = [self._node(name) for name in reversed(names)]

    def send(self, frame: Frame) -> None:
        """Queue it at its identifier's node; raises QueueFull if that, or every node, is busy."""
        key = frame.extended, frame.id
        node = self._serving.get(key)
        if node is None:
            node = self._serving[key] = self._next()
        node.send(frame)

    def _next(self) -> LabNode:
        if not self._free:
            for key in [key for key, node in self._serving.items() if not node.pending]:
                self._free.append(self._serving.pop(key))
        if not self._free and self._grows and self._made < min(MOST, POOL):
            self._free.append(self._node(f"sender {self._made}"))
        if not self._free:
            raise QueueFull("the log's senders, all at work", self._made)
        return self._free.pop()

    def _node(self, name: str) -> LabNode:
        self._made += 1
        return self._bus.node(name, receives=False, receive_queue=1, transmit_queue=_QUEUE)
