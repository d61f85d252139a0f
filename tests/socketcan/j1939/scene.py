"""J1939 networks on a bus of this file, in a time of its own: a frame is there FRAME_S after it was put."""

from __future__ import annotations

from canwire.socketcan.j1939.endpoint import Endpoint
from canwire.socketcan.j1939.message import Message, message_of
from canwire.socketcan.j1939.network import Network
from canwire.socketcan.j1939.outbox import Outbox
from canwire.socketcan.j1939.reports import Report
from tests.socketcan.clock import Clock

FRAME_S = 0.0002


class Socket:
    """What a program has: bound to a name or an address, it keeps what it hears and is told."""

    def __init__(self, node: Node, address: int, name: int = 0, *, broadcasts: bool = True) -> None:
        self.node = node
        self.heard: list[Message] = []
        self.reports: list[Report] = []
        self.over: list[int] = []
        self.endpoint = Endpoint(lambda: broadcasts, self.deliver, self.reports.append)
        self.endpoint.address, self.endpoint.name = address, name
        node.network.endpoints.append(self.endpoint)
        node.network.addresses.use(name, address)
        self.outbox = Outbox(node.network, self.endpoint, self.over.append)
        node.sockets.append(self)

    def deliver(self, message: Message, _: int, __: bool) -> None:
        self.heard.append(message)

    def send(self, pgn: int, data: bytes, to: int = 0xFF, to_name: int = 0) -> None:
        self.outbox.send(self.endpoint.message(data, pgn, to_name, to))

    def claim(self, address: int) -> None:
        self.node.network.addresses.leave(self.endpoint.name, self.endpoint.address)
        self.endpoint.address = address
        self.node.network.addresses.use(self.endpoint.name, address)
        self.send(0xEE00, self.endpoint.name.to_bytes(8, "little"))

    @property
    def data(self) -> list[bytes]:
        return [message.data for message in self.heard]


class Node:
    """A computer on the bus."""

    def __init__(self, scene: Scene, largest: int) -> None:
        self.network = Network(
            scene.clock, lambda message, endpoint: scene.put(self, message, endpoint), largest
        )
        self.sockets: list[Socket] = []

    def take(self, message: Message, sender: Endpoint | None, *, own: bool) -> None:
        for one in self.sockets:
            if own and one.endpoint is sender and len(message.data) <= 8:
                one.outbox.confirm(message)
        self.network.take(message, 0, sender if own else None, own)


class Scene:
    """`lines` is what was on the bus: identifier and data; `lose` swallows frames with such PGNs."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.lines: list[str] = []
        self.times_ms: list[float] = []
        self.lose: set[int] = set()
        self._nodes: list[Node] = []

    def node(self, largest: int = 1 << 20) -> Node:
        made = Node(self, largest)
        self._nodes.append(made)
        return made

    def put(self, node: Node | None, message: Message, sender: Endpoint | None = None) -> None:
        def arrive() -> None:
            self.lines.append(f"{message.identifier:08X} {message.data.hex()}")
            self.times_ms.append(round((self.clock.now_s - 100) * 1000, 1))
            heard = message_of(message.identifier, message.data)
            for one in self._nodes:
                one.take(heard, sender, own=one is node)

        if message.pgn not in self.lose:
            self.clock.call_in(FRAME_S, arrive)

    def inject(self, line: str) -> None:
        """A frame of somebody else's: identifier and data."""
        identifier, data = line.split()
        self.put(None, message_of(int(identifier, 16), bytes.fromhex(data)))
        self.clock.run_for(2 * FRAME_S)

    def run_for(self, seconds: float) -> None:
        self.clock.run_for(seconds)
