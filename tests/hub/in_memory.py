"""A hub without sockets, threads or clocks: clients talk to one world in virtual time, through the wire's bytes."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from canwire.boards.can.modes import ChannelMode, LineMode
from canwire.boards.config.configuration import Config
from canwire.boards.config.tables import BoardConfig
from canwire.errors import CanwireError, HubLost
from canwire.hub.handles.channel import HubChannel
from canwire.hub.handles.control import Control
from canwire.hub.handles.hub import Hub
from canwire.hub.owner.deferred import Deferred
from canwire.hub.owner.entrance import open_session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer
from canwire.hub.protocol.queues import transmit_offset
from canwire.platform import EventDescriptor, map_memory
from canwire.timeline import NEVER
from canwire.values.timing.bit_timing import BitTiming

NOMINAL = BitTiming.for_bit_rate(500_000, clock_hz=80_000_000)
DATA = BitTiming.for_bit_rate(2_000_000, clock_hz=80_000_000)
CLASSIC = LineMode(NOMINAL)
FD = LineMode(NOMINAL, DATA, long_data=True)
TWO_BOARDS = Config(
    bus=Config.default().bus,
    board=(
        BoardConfig(kind="usb-to-can-fd", serial="HW000001"),
        BoardConfig(kind="usb-to-can", serial="HW000002"),
    ),
)


class InMemory:
    """hub/protocol/link.py's Link. Every request, reply and notice goes through its bytes and back.

    With `on_wait` a request whose answer takes time has it called instead of time passing. `memory` is that of
    the queues of each channel or monitor that was set up: the receive ring, and the transmit ring if it has one.
    """

    time = "virtual"
    address = ""

    def __init__(self, world: World, name: str = "test", pid: int = 1) -> None:
        self.world = world
        self.lost = False
        self.on_wait: Callable[[], None] | None = None
        self.notices: list[m.Message] = []
        self.memory: dict[int, list[memoryview]] = {}
        self._bell = EventDescriptor()
        self._listeners: list[Callable[[m.Message | None], None]] = []
        self._serial = 0
        self.session = open_session(world, name, pid, self._note, self._bell)

    @property
    def doorbell(self) -> EventDescriptor:
        return self._bell

    def call(self, request: m.Message) -> Answer:
        if self.lost:
            raise HubLost("the hub is gone")
        self._serial += 1
        payload = m.encode_request(self._serial, request)[m.LENGTH.size :]
        serial, decoded = m.decode_request(payload)
        assert (serial, decoded) == (self._serial, request)
        answer = self.session.handle(decoded)
        if isinstance(answer, Deferred):
            answer = self._waited(answer)
        reply, descriptors = answer
        encoded = m.encode_reply(serial, reply, len(descriptors))[m.LENGTH.size :]
        assert m.decode_reply(encoded) == (serial, len(descriptors), reply)
        if isinstance(request, m.SetUpChannel):
            memory, begin = map_memory(descriptors[0]), transmit_offset(reply.receive)
            self.memory[request.handle] = [memory[:begin], memory[begin:]] if reply.transmit else [memory]
        elif isinstance(request, m.SetUpMonitor):
            self.memory[request.handle] = [map_memory(descriptors[0])]
        elif isinstance(request, m.Close):
            self.memory.pop(request.handle, None)
        return m.decode_reply(encoded)[2], descriptors

    def listen(self, listener: Callable[[m.Message | None], None]) -> None:
        self._listeners.append(listener)

    def close(self) -> None:
        self.die()
        self._bell.close()

    def die(self) -> None:
        """The client is gone all of a sudden: nothing was closed."""
        self.lost = True
        self.memory.clear()
        self.world.close_session(self.session)

    def vanish(self) -> None:
        """The hub dies, as this client sees it."""
        self.lost = True
        for listener in self._listeners:
            listener(None)

    def _note(self, notice: m.Message) -> None:
        decoded = m.decode_reply(m.encode_reply(0, notice)[m.LENGTH.size :])
        assert decoded == (0, 0, notice)
        self.notices.append(decoded[2])
        for listener in self._listeners:
            listener(decoded[2])

    def _waited(self, deferred: Deferred) -> Answer:
        outcomes: list[Answer | CanwireError] = []
        deferred.on_done(outcomes.append)
        self.world.kick_all()
        if not outcomes and self.on_wait is not None:
            self.on_wait()
        while not outcomes:
            due_ns = self.world.timeline.next_ns()
            assert due_ns < NEVER, "this answer never comes"
            self.world.timeline.run_until(due_ns)
        if isinstance(outcomes[0], CanwireError):
            raise outcomes[0]
        return outcomes[0]


class Bench:
    """One world and any number of clients; `close` lets all of them go."""

    def __init__(self, config: Config | None = None) -> None:
        self.world = World(TWO_BOARDS if config is None else config, virtual=True)
        self.hubs: list[Hub] = []
        self.links: list[InMemory] = []

    def hub(self, name: str = "test") -> Hub:
        """One more client."""
        self.links.append(InMemory(self.world, name, 100 + len(self.links)))
        self.hubs.append(Hub(self.links[-1]))
        return self.hubs[-1]

    def link(self, hub: Hub) -> InMemory:
        return self.links[self.hubs.index(hub)]

    @property
    def board(self) -> int:
        """The id of the first board."""
        return next(iter(self.world.boards))

    def control(self, hub: Hub, line: int = 0, mode: LineMode = FD) -> Control:
        """A line that runs, and its control."""
        control = hub.open_control(self.board, line)
        control.initialise(mode)
        control.start()
        hub.run_for(0.001)
        return control

    def channel(self, hub: Hub, line: int = 0, mode: ChannelMode | None = None) -> HubChannel:
        """An active channel on a line."""
        channel = hub.open_channel(self.board, line)
        channel.set_up(mode or ChannelMode(64, 64))
        channel.activate()
        return channel

    def close(self) -> None:
        for hub in self.hubs:
            hub.close()


def bench_of(config: Config | None = None) -> object:
    """The fixture `bench` of a file: a bench of this world (none: two boards) for each test."""

    @pytest.fixture
    def bench() -> Iterator[Bench]:
        made = Bench(config)
        yield made
        made.close()

    return bench
