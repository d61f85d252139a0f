"""The nodes that send a log's frames: one for each identifier, as in a car, as far as a bus can carry them.

What a bus does for a frame grows with its nodes. Where a log has more identifiers than MOST (J1939's sessions, a
fuzzer's random ones), MOST nodes take turns: each serves one identifier until its frames have gone out, then another.
Frames that are due together arbitrate as before, up to MOST of them.
"""

from __future__ import annotations

from collections.abc import Collection

from canwire import Frame, LabBus, LabNode, QueueFull

MOST = 256
_QUEUE = 1024
Key = tuple[bool, int]  # extended, identifier


class Senders:
    """All of them are on the bus before the first frame."""

    def __init__(self, bus: LabBus, keys: Collection[Key]) -> None:
        names = [f"{id:08X}" if extended else f"{id:03X}" for extended, id in keys]
        if len(names) > MOST:
            names = [f"sender {number}" for number in range(MOST)]
        self._free = [
            bus.node(name, receives=False, receive_queue=1, transmit_queue=_QUEUE) for name in reversed(names)
        ]
        self._serving: dict[Key, LabNode] = {}

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
        if not self._free:
            raise QueueFull("the log's senders, all at work", MOST)
        return self._free.pop()
