"""A network between machines that delays, loses, throttles and cuts, each direction for itself; it counts packets."""

from __future__ import annotations

import contextlib
import heapq
import os
import random
import selectors
import socket
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

_LARGEST = 65_536
_DESTINATION = slice(16, 20)  # of an IPv4 header


@dataclass
class Way:
    """One direction between two machines.

    `rate` is bytes per second (None: any), and `queue` how many bytes may wait for it.
    `loss` is the share of packets that vanish, 0 to 1. What is `cut` lets nothing through.
    """

    cut: bool = False
    loss: float = 0.0
    delay_s: float = 0.0
    rate: float | None = None
    queue: int = 65_536
    passed: int = 0
    dropped: int = 0
    _free_s: float = field(default=0.0, repr=False)

    def due_s(self, now_s: float, size: int, dice: random.Random) -> float | None:
        """When the packet arrives; None: never."""
        begins_s = max(now_s, self._free_s)
        late = self.rate is not None and (begins_s - now_s) * self.rate > self.queue
        if self.cut or late or (self.loss and dice.random() < self.loss):
            self.dropped += 1
            return None
        self.passed += 1
        self._free_s = begins_s if self.rate is None else begins_s + size / self.rate
        return self._free_s + self.delay_s


class Spoiler:
    """Carries packets between interfaces, by address, in a thread; `ways` says how, and may change at any time."""

    def __init__(self, ends: Sequence[int], addresses: Sequence[str], seed: int = 0) -> None:
        self.ways = {(a, b): Way() for a in range(len(ends)) for b in range(len(ends)) if a != b}
        self._ends = ends
        self._number_of = {socket.inet_aton(address): number for number, address in enumerate(addresses)}
        self._random = random.Random(seed)
        self._coming: list[tuple[float, int, int, bytes]] = []
        self._count = 0
        self._wake, self._over = os.pipe()
        self._thread = threading.Thread(target=self._run, name="spoiler", daemon=True)
        self._thread.start()

    def heal(self) -> None:
        """Every way is as good as new."""
        for way in self.ways.values():
            way.cut, way.loss, way.delay_s, way.rate = False, 0.0, 0.0, None

    def close(self) -> None:
        """Nothing is carried any more; the interfaces stay the caller's."""
        os.close(self._over)
        self._thread.join()
        os.close(self._wake)

    def _run(self) -> None:
        with selectors.DefaultSelector() as selector:
            for number, end in enumerate(self._ends):
                selector.register(end, selectors.EVENT_READ, number)
            selector.register(self._wake, selectors.EVENT_READ, None)
            while True:
                wait_s = None if not self._coming else max(0.0, self._coming[0][0] - time.monotonic())
                for key, _ in selector.select(wait_s):
                    if key.data is None:
                        return
                    self._take(key.data)
                self._deliver()

    def _take(self, source: int) -> None:
        with contextlib.suppress(BlockingIOError):
            while True:
                packet, now_s = os.read(self._ends[source], _LARGEST), time.monotonic()
                way = self.ways.get((source, self._number_of.get(packet[_DESTINATION], source)))
                due_s = None if way is None else way.due_s(now_s, len(packet), self._random)
                if due_s is not None:
                    self._count += 1
                    target = self._number_of[packet[_DESTINATION]]
                    heapq.heappush(self._coming, (due_s, self._count, target, packet))

    def _deliver(self) -> None:
        now_s = time.monotonic()
        while self._coming and self._coming[0][0] <= now_s:
            _, _, target, packet = heapq.heappop(self._coming)
            with contextlib.suppress(BlockingIOError):  # its interface is full, as a switch's port may be
                os.write(self._ends[target], packet)
