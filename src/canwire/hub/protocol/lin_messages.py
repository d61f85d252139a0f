"""Requests and replies about LIN lines; messages.py includes them."""

from __future__ import annotations

from typing import get_args

from canwire.boards.lin.modes import LinLineStatus, LinMode, LinMonitorMode, LinMonitorStatus
from canwire.hub.protocol.message import Message
from canwire.values.lin.configuration import LinProduct
from canwire.values.lin.schedule import LinSchedule

# a client's requests; the reply to each one follows "->"


class GetLinStatus(Message):
    """-> LinLineState"""

    board: int
    line: int


class GetLinStatuses(Message):
    """-> LinStatuses: the LIN lines of these boards, like GetLineStatuses for CAN lines."""

    boards: tuple[int, ...]


class InitialiseLin(Message):
    """Control of a LIN line -> None"""

    handle: int
    mode: LinMode


class WriteLin(Message):
    """Control of a LIN line -> None. `record` is that of a frame (values/lin/record.py). With `send` it is sent now,
    else it answers its header from now on."""

    handle: int
    record: bytes
    send: bool


class WakeLin(Message):
    """Control of a LIN line -> None: a wake-up pulse; with `sleep` the go-to-sleep command instead."""

    handle: int
    sleep: bool


class RunSchedule(Message):
    """Control of a LIN line -> None. `rounds` 0: no limit; without a `schedule`, the running one ends."""

    handle: int
    schedule: LinSchedule | None
    rounds: int


class ConfigureLin(Message):
    """Control of a LIN line -> None: the slave answers node configuration from now on, by LinNodeAttributes."""

    handle: int
    product: LinProduct
    nad: int
    frames: dict[int, int]
    serial: int | None
    identifiers: dict[int, bytes]
    message_ids: bool
    p2_ns: int
    n_as_ns: int
    n_cr_ns: int


class GetLinConfiguration(Message):
    """Control of a LIN line -> LinConfiguration; with `power_up` the slave first restores what was saved last."""

    handle: int
    power_up: bool


class RequestLin(Message):
    """Control of a LIN line -> Note, the payload that answers; deferred for `within_ns` at most."""

    handle: int
    nad: int
    payload: bytes
    within_ns: int


class OpenMonitor(Message):
    """-> Opened"""

    board: int
    line: int
    exclusive: bool


class SetUpMonitor(Message):
    """Monitor -> ChannelOpened, with descriptors: receive memory, its event."""

    handle: int
    mode: LinMonitorMode


class GetMonitorStatus(Message):
    """Monitor -> MonitorState"""

    handle: int


# the hub's replies


class LinLineState(Message):
    """`control_holder` is "" if no program has the control; `exclusive`: a monitor uses the line exclusively."""

    status: LinLineStatus
    control_holder: str
    exclusive: bool


class LinStatuses(Message):
    """Each status with its board and line number."""

    values: tuple[tuple[int, int, LinLineState], ...]


class LinConfiguration(Message):
    """The NAD of a configured slave, and the identifiers of its frames by index (None: unassigned)."""

    nad: int
    frames: dict[int, int | None]


class MonitorState(Message):
    status: LinMonitorStatus


LinRequest = (
    GetLinStatus
    | GetLinStatuses
    | InitialiseLin
    | WriteLin
    | WakeLin
    | RunSchedule
    | ConfigureLin
    | GetLinConfiguration
    | RequestLin
    | OpenMonitor
    | SetUpMonitor
    | GetMonitorStatus
)
LinReply = LinLineState | LinStatuses | LinConfiguration | MonitorState
NAMES = frozenset(message.__name__ for message in get_args(LinRequest | LinReply))
