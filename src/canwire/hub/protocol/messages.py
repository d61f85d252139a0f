"""Requests of a client to its hub, and the replies, as values and as bytes.

On the wire: a length (4 bytes, little-endian), then msgpack of [serial, message]. A client's first message is `Hello`;
every request gets one `Reply` or `Failed` with its serial, in any order; serial 0 is a notice. Descriptors (memory,
events) travel with the reply that counts them. Lengths above the bounds, unknown messages and fields of a wrong type
raise BadMessage, and their receiver closes the connection. `kin` is always the interface that a program uses.
"""

from __future__ import annotations

import struct
import sys
from functools import cache
from typing import TYPE_CHECKING, Any, get_args

import msgspec

from canwire.boards.can.modes import ChannelMode, ChannelStatus, CyclicStatus, LineMode, LineStatus
from canwire.boards.description import BoardInfo
from canwire.errors import BadMessage, BadValue
from canwire.hub.protocol.board_messages import Annotate as Annotate
from canwire.hub.protocol.board_messages import GetLineStatuses as GetLineStatuses
from canwire.hub.protocol.board_messages import GetNote as GetNote
from canwire.hub.protocol.board_messages import GetRegisters as GetRegisters
from canwire.hub.protocol.board_messages import HoldInterrupts as HoldInterrupts
from canwire.hub.protocol.board_messages import KeepSettings as KeepSettings
from canwire.hub.protocol.board_messages import LineStatuses as LineStatuses
from canwire.hub.protocol.board_messages import ListNotes as ListNotes
from canwire.hub.protocol.board_messages import Note as Note
from canwire.hub.protocol.board_messages import Notes as Notes
from canwire.hub.protocol.board_messages import OpenShare as OpenShare
from canwire.hub.protocol.board_messages import PassOn as PassOn
from canwire.hub.protocol.board_messages import ReadRegister as ReadRegister
from canwire.hub.protocol.board_messages import Registers as Registers
from canwire.hub.protocol.board_messages import SetNote as SetNote
from canwire.hub.protocol.board_messages import Sleep as Sleep
from canwire.hub.protocol.board_messages import WriteRegister as WriteRegister
from canwire.hub.protocol.channel_messages import CountRefused as CountRefused
from canwire.hub.protocol.channel_messages import ReplaceFilters as ReplaceFilters
from canwire.hub.protocol.cyclic_messages import AddCyclic as AddCyclic
from canwire.hub.protocol.cyclic_messages import GetSchedulerStatus as GetSchedulerStatus
from canwire.hub.protocol.cyclic_messages import OpenScheduler as OpenScheduler
from canwire.hub.protocol.cyclic_messages import RemoveCyclic as RemoveCyclic
from canwire.hub.protocol.cyclic_messages import ReplaceCyclic as ReplaceCyclic
from canwire.hub.protocol.cyclic_messages import ResetScheduler as ResetScheduler
from canwire.hub.protocol.cyclic_messages import RunScheduler as RunScheduler
from canwire.hub.protocol.cyclic_messages import StartCyclic as StartCyclic
from canwire.hub.protocol.cyclic_messages import StartInTurn as StartInTurn
from canwire.hub.protocol.cyclic_messages import StopCyclic as StopCyclic
from canwire.hub.protocol.fault_messages import AwaitFault as AwaitFault
from canwire.hub.protocol.fault_messages import BusFound as BusFound
from canwire.hub.protocol.fault_messages import CancelFault as CancelFault
from canwire.hub.protocol.fault_messages import ClearFaults as ClearFaults
from canwire.hub.protocol.fault_messages import FaultList as FaultList
from canwire.hub.protocol.fault_messages import FaultState as FaultState
from canwire.hub.protocol.fault_messages import GetBus as GetBus
from canwire.hub.protocol.fault_messages import GetFault as GetFault
from canwire.hub.protocol.fault_messages import ListFaults as ListFaults
from canwire.hub.protocol.fault_messages import SetFault as SetFault
from canwire.hub.protocol.fifo_messages import CreateFifo as CreateFifo
from canwire.hub.protocol.fifo_messages import FifoOpened as FifoOpened
from canwire.hub.protocol.fifo_messages import OpenFifo as OpenFifo
from canwire.hub.protocol.fifo_messages import ResetFifo as ResetFifo
from canwire.hub.protocol.message import Message as Message
from canwire.hub.protocol.time_messages import AwaitTurn as AwaitTurn
from canwire.hub.protocol.time_messages import GetTime as GetTime
from canwire.hub.protocol.time_messages import Joined as Joined
from canwire.hub.protocol.time_messages import JoinTime as JoinTime
from canwire.hub.protocol.time_messages import LeaveTime as LeaveTime
from canwire.hub.protocol.time_messages import SetPace as SetPace
from canwire.hub.protocol.time_messages import Stir as Stir
from canwire.hub.protocol.time_messages import TimeState as TimeState
from canwire.values.timing.bit_timing import BitTiming

if TYPE_CHECKING:  # what __getattr__ says to the interpreter
    from canwire.hub.protocol.lin_messages import ConfigureLin as ConfigureLin
    from canwire.hub.protocol.lin_messages import GetLinConfiguration as GetLinConfiguration
    from canwire.hub.protocol.lin_messages import GetLinStatus as GetLinStatus
    from canwire.hub.protocol.lin_messages import GetLinStatuses as GetLinStatuses
    from canwire.hub.protocol.lin_messages import GetMonitorStatus as GetMonitorStatus
    from canwire.hub.protocol.lin_messages import InitialiseLin as InitialiseLin
    from canwire.hub.protocol.lin_messages import LinLineState as LinLineState
    from canwire.hub.protocol.lin_messages import LinStatuses as LinStatuses
    from canwire.hub.protocol.lin_messages import MonitorState as MonitorState
    from canwire.hub.protocol.lin_messages import OpenMonitor as OpenMonitor
    from canwire.hub.protocol.lin_messages import RequestLin as RequestLin
    from canwire.hub.protocol.lin_messages import RunSchedule as RunSchedule
    from canwire.hub.protocol.lin_messages import SetUpMonitor as SetUpMonitor
    from canwire.hub.protocol.lin_messages import WakeLin as WakeLin
    from canwire.hub.protocol.lin_messages import WriteLin as WriteLin

VERSION = 7
LARGEST_REQUEST = 1 << 16
LARGEST_REPLY = 1 << 22
LENGTH = struct.Struct("<I")


# a client's requests; the reply to each one follows "->"


class Hello(Message):
    """-> Welcome. Other programs see `name` with each lease of this client."""

    version: int
    pid: int
    name: str


class ListBoards(Message):
    """-> Boards: a page of them, those with ids above `after`."""

    after: int = 0


class Watch(Message):
    """-> None; a BoardsChanged notice follows every later change of the list."""


class Plug(Message):
    """-> BoardInfo. With `serial` "" the hub chooses one; `buses` names a bus for each line, (): the kind's default.

    `base`, `irq` and `shared_irq` are for an ISA board, None: as delivered. `port` is the place of an adapter. A
    `temporary` board is pulled out when this client is gone.
    """

    kind: str
    serial: str
    buses: tuple[str, ...]
    base: int | None = None
    irq: int | None = None
    shared_irq: bool = False
    port: str = ""
    temporary: bool = False


class Unplug(Message):
    """-> None"""

    hardware_id: str


class OpenLayer(Message):
    """-> Opened. Any number of clients share one access layer of a board, two layers exclude each other."""

    board: int
    layer: str


class OpenControl(Message):
    """-> Opened. One at a time for each line."""

    board: int
    line: int
    kin: str = ""


class OpenChannel(Message):
    """-> Opened"""

    board: int
    line: int
    exclusive: bool


class Close(Message):
    """-> None"""

    handle: int


class GetLineStatus(Message):
    """-> LineState, as programs of the interface `kin` see it"""

    board: int
    line: int
    kin: str = ""


class Initialise(Message):
    """Control -> None; deferred while the line searches for its bit rate."""

    handle: int
    mode: LineMode


class Start(Message):
    """Control -> None; with `abort_pending`, frames queued on the line are discarded before."""

    handle: int
    abort_pending: bool = False


class Stop(Message):
    """Control -> None, once the frame on the wire is over."""

    handle: int


class Recover(Message):
    """-> None: a line in bus-off returns to the bus; any client with a lease on the line may request this."""

    board: int
    line: int
    abort_pending: bool


class Reset(Message):
    """Control -> None"""

    handle: int


class Detect(Message):
    """Control -> Number: the index of the first rate (nominal, data or None) that is the rate of the bus."""

    handle: int
    candidates: tuple[tuple[BitTiming, BitTiming | None], ...]
    timeout_ms: int
    iso_fd: bool
    low_speed: bool


class GetFilterMode(Message):
    """Control or channel -> Number"""

    handle: int
    extended: bool


class SetFilterMode(Message):
    """Control or channel -> Number: the previous mode."""

    handle: int
    extended: bool
    mode: int


class SetAcceptanceFilter(Message):
    """Control or channel -> None"""

    handle: int
    extended: bool
    code: int
    mask: int


class ListIds(Message):
    """Control or channel -> None; `add` False removes."""

    handle: int
    extended: bool
    code: int
    mask: int
    add: bool


class SetUpChannel(Message):
    """Channel -> ChannelOpened, with descriptors: memory (queues.py), receive event, [transmit event]."""

    handle: int
    mode: ChannelMode


class Activate(Message):
    """Channel -> LineState, monitor -> LinLineState: the line at that moment; the hub's lateness is 0."""

    handle: int
    active: bool


class GetChannelStatus(Message):
    """Channel -> ChannelState"""

    handle: int


class CancelQueued(Message):
    """Channel -> Number of frames discarded; without `loaded`, frames in the controller stay."""

    handle: int
    loaded: bool = True


class CreateLuid(Message):
    """-> Number, never returned before."""


class Disturb(Message):
    """-> None: short the wires of a bus, or remove the short."""

    bus: str
    shorted: bool


class Advance(Message):
    """-> Number: the time in ns. Lets `span_ns` of virtual time pass, less if one of this client's events is
    signalled first; in real and fast time it only returns the time."""

    span_ns: int


Request = (
    Hello | ListBoards | Watch | Plug | Unplug | OpenLayer | OpenControl | OpenChannel | OpenScheduler | Close
    | GetLineStatus | Initialise | Start | Stop | Recover | Reset | Detect | GetFilterMode | SetFilterMode
    | SetAcceptanceFilter | ListIds | ReplaceFilters | CountRefused | SetUpChannel | Activate | GetChannelStatus
    | CancelQueued | PassOn | Annotate | AddCyclic | RemoveCyclic | StartCyclic | StopCyclic | RunScheduler
    | ResetScheduler | GetSchedulerStatus | CreateFifo | OpenFifo | ResetFifo | CreateLuid | Disturb
    | Advance | GetRegisters | SetNote | GetNote | ReplaceCyclic | StartInTurn | KeepSettings | OpenShare
    | ReadRegister | WriteRegister | Sleep | HoldInterrupts | ListNotes | GetBus | SetFault | GetFault | AwaitFault
    | CancelFault | ListFaults | ClearFaults | JoinTime | AwaitTurn | LeaveTime | Stir | GetTime | SetPace
    | GetLineStatuses
)  # fmt: skip

# the hub's replies


class Done(Message):
    """A reply without a result."""


class Number(Message):
    value: int


class Welcome(Message):
    """`time` is "real", "fast", "virtual" or "lockstep"; one descriptor: this client's doorbell."""

    version: int
    time: str


class Boards(Message):
    """Boards in the order of their ids; `more`: further boards follow the last one."""

    boards: tuple[BoardInfo, ...]
    more: bool = False


class Plugged(Message):
    board: BoardInfo


class Opened(Message):
    handle: int


class ChannelOpened(Message):
    """The actual sizes of a channel's queues, in frames."""

    receive: int
    transmit: int


class LineState(Message):
    status: LineStatus


class ChannelState(Message):
    status: ChannelStatus


class SchedulerState(Message):
    status: CyclicStatus


class Failed(Message):
    """The request raised: name of a class in canwire.errors, and its text."""

    error: str
    text: str


# the hub's notices


class BoardsChanged(Message):
    """A board was plugged in or out."""


class Gone(Message):
    """These handles are invalid: their board was unplugged."""

    handles: tuple[int, ...]
    text: str


Reply = (
    Done | Number | Welcome | Boards | Plugged | Opened | ChannelOpened | LineState | LineStatuses | ChannelState
    | SchedulerState | FifoOpened | Registers | Note | Notes | Failed | BoardsChanged
    | Gone | BusFound | FaultState | FaultList | Joined | TimeState
)  # fmt: skip


_encoder = msgspec.msgpack.Encoder()
_replies = msgspec.msgpack.Decoder(tuple[int, int, Reply])
_LIN = "canwire.hub.protocol.lin_messages"


@cache
def _requests_of(kind: type) -> msgspec.msgpack.Decoder[tuple[int, Any]]:
    """Return the decoder of one kind: a client needs few; a decoder of all takes a twentieth of its start."""
    known: Any = Request
    if _LIN in sys.modules:
        from canwire.hub.protocol.lin_messages import LinRequest

        known = Request | LinRequest
    if kind not in get_args(known):
        raise TypeError("this is no request")
    return msgspec.msgpack.Decoder(tuple[int, kind])  # type: ignore[valid-type]


@cache
def _all_requests() -> msgspec.msgpack.Decoder[tuple[int, Any]]:
    """Return the decoder of all requests, which a hub needs and clients do not."""
    from canwire.hub.protocol.lin_messages import LinRequest

    return msgspec.msgpack.Decoder(tuple[int, Request | LinRequest])


@cache
def _all_replies() -> msgspec.msgpack.Decoder[tuple[int, int, Any]]:
    from canwire.hub.protocol.lin_messages import LinReply

    return msgspec.msgpack.Decoder(tuple[int, int, Reply | LinReply])


def _load(name: str) -> Any:
    """Load messages about LIN when one is first used: loading them takes a tenth of a program's start."""
    if not name.startswith("_"):  # the interpreter asks for __path__, say
        from canwire.hub.protocol import lin_messages

        if name in lin_messages.NAMES:
            return getattr(lin_messages, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


if not TYPE_CHECKING:
    __getattr__ = _load


def encode_request(serial: int, request: Message) -> bytes:
    """Return the bytes to send; raises BadValue for wrong types, too large numbers, or too long a request."""
    try:
        message = _framed((serial, request), LARGEST_REQUEST)
        _decoded(_requests_of(type(request)), message[LENGTH.size :], "request")
    except (BadMessage, BufferError, TypeError, OverflowError, RecursionError) as error:
        raise BadValue(f"{type(request).__name__}: {error}") from None
    return message


def encode_reply(serial: int, reply: Message, descriptors: int = 0) -> bytes:
    """Return the bytes to send; `descriptors` is the number sent with them. Serial 0 makes a notice."""
    return _framed((serial, descriptors, reply), LARGEST_REPLY)


def decode_request(payload: bytes | bytearray | memoryview) -> tuple[int, Any]:
    """Return serial and request; raises BadMessage."""
    return _decoded(_all_requests(), payload, "request")


def decode_reply(payload: bytes | bytearray | memoryview) -> tuple[int, int, Any]:
    """Return serial, number of descriptors and reply; raises BadMessage."""
    # only who has asked about LIN is answered about LIN
    return _decoded(_all_replies() if _LIN in sys.modules else _replies, payload, "reply")


def _decoded(decoder: Any, payload: bytes | bytearray | memoryview, what: str) -> Any:
    try:
        return decoder.decode(payload)
    except (msgspec.MsgspecError, ValueError) as error:
        raise BadMessage(f"a {what} of {len(payload)} bytes: {error}") from None


def _framed(message: Any, largest: int) -> bytes:
    payload = _encoder.encode(message)
    if len(payload) > largest:
        raise BadMessage(f"a message of {len(payload)} bytes: {largest} at most")
    return LENGTH.pack(len(payload)) + payload


class Inbox:
    """Splits the bytes of a stream into whole payloads."""

    def __init__(self, largest: int) -> None:
        self._largest = largest
        self._bytes = bytearray()

    def feed(self, data: bytes) -> list[bytes]:
        """Return the payloads that are complete now, in order; raises BadMessage for a length out of bounds."""
        self._bytes += data
        payloads = []
        while len(self._bytes) >= LENGTH.size:
            (length,) = LENGTH.unpack_from(self._bytes)
            if not 0 < length <= self._largest:
                raise BadMessage(f"a message of {length} bytes: 1 to {self._largest}")
            if len(self._bytes) < LENGTH.size + length:
                break
            payloads.append(bytes(self._bytes[LENGTH.size : LENGTH.size + length]))
            del self._bytes[: LENGTH.size + length]
        return payloads
