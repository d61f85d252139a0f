"""A python-can bus with two threads: one opens it and reads, one sends. Both only post what they find out.

python-can's objects stay in here: others get records of 80 bytes and times.
"""

from __future__ import annotations

import contextlib
import queue
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

from canwire.drivers.outside import Reactor
from canwire.drivers.python_can.backends import PASSIVE, backend
from canwire.drivers.python_can.port import Port
from canwire.errors import CanwireError, ExtraMissing
from canwire.values.event import ErrorState
from canwire.values.frame import Frame, record_of_frame
from canwire.values.timing.bit_timing import BitTiming

FIRST_RETRY_S, LONGEST_RETRY_S = 0.1, 5.0
_LOOK_S = 0.1  # how long a reader waits before it looks whether it is still wanted
_STATE_S = 0.5
_SEND_S = 1.0
_TRIES_S = (0.002, 0.01, 0.05)  # pauses before a frame is tried again
_BATCH, _BATCHES = 256, 8

monotonic_ns = time.monotonic_ns


@dataclass(frozen=True, slots=True)
class Setup:
    """How the bus is to be opened."""

    timing: BitTiming
    data_timing: BitTiming | None
    listen_only: bool


class Heard(NamedTuple):
    """A message as the hub's thread takes it: `error` (identifier, data) instead of a record for error frames."""

    record: bytes
    error: tuple[int, bytes] | None
    stamp_ns: int
    arrived_ns: int


class User:
    """What happens, told in the hub's thread; `adapter` says which one tells."""

    def opened(self, adapter: Adapter, what: str) -> None: ...
    def failed(self, adapter: Adapter, why: str) -> None: ...
    def lost(self, adapter: Adapter, why: str) -> None: ...
    def heard(self, adapter: Adapter, batch: list[Heard]) -> None: ...
    def sent(self, adapter: Adapter, why_not: str) -> None: ...
    def in_state(self, adapter: Adapter, state: ErrorState) -> None: ...


class Adapter:
    """Opens the bus, again and again if need be, until `close`."""

    def __init__(self, port: Port, setup: Setup, reactor: Reactor, user: User) -> None:
        self._port = port
        self._setup = setup
        self._reactor = reactor
        self._user = user
        self._room = threading.Semaphore(_BATCHES)
        self._closed = threading.Event()
        self._outgoing: queue.SimpleQueue[Frame | None] = queue.SimpleQueue()
        self._kind = backend(port.interface)
        threading.Thread(target=self._run, name="canwire-python-can", daemon=True).start()

    def send(self, frame: Frame) -> None:
        """`sent` is told of each."""
        self._outgoing.put(frame)

    def close(self) -> None:
        """Nothing more is told."""
        self._closed.set()
        self._outgoing.put(None)

    # in threads of its own

    def _tell(self, work: Callable[[], object]) -> None:
        with contextlib.suppress(CanwireError):  # the hub has ended
            self._reactor.post(lambda: None if self._closed.is_set() else work())

    def _run(self) -> None:
        wait_s = FIRST_RETRY_S
        while not self._closed.is_set():
            try:
                bus = open_bus(self._port, self._setup)
            except Exception as error:  # somebody else's code: anything may come
                self._tell(partial(self._user.failed, self, _text_of(error)))
                if isinstance(error, ExtraMissing):
                    return
                self._closed.wait(wait_s)
                wait_s = min(2 * wait_s, LONGEST_RETRY_S)
                continue
            wait_s = FIRST_RETRY_S
            self._use(bus)

    def _use(self, bus: Any) -> None:
        sender = threading.Thread(
            target=self._send, args=(bus, self._outgoing), name="canwire-python-can", daemon=True
        )
        sender.start()
        self._tell(partial(self._user.opened, self, str(getattr(bus, "channel_info", ""))))
        try:
            self._read(bus)
        except Exception as error:
            self._tell(partial(self._user.lost, self, _text_of(error)))
            self._closed.wait(FIRST_RETRY_S)
        finally:
            outgoing, self._outgoing = self._outgoing, queue.SimpleQueue()
            outgoing.put(None)
            sender.join(_SEND_S)
            with contextlib.suppress(Exception):
                bus.shutdown()

    def _read(self, bus: Any) -> None:
        state, look_ns = ErrorState.ERROR_ACTIVE, 0
        while not self._closed.is_set():
            message = bus.recv(_LOOK_S)
            batch: list[Heard] = []
            while message is not None:
                if (heard := _heard(message)) is not None:
                    batch.append(heard)
                message = bus.recv(0) if len(batch) < _BATCH else None
            if batch:
                while not self._room.acquire(timeout=_LOOK_S):
                    if self._closed.is_set():
                        return
                self._tell(partial(self._deliver, batch))
            if self._kind.state and monotonic_ns() >= look_ns:
                look_ns = monotonic_ns() + int(_STATE_S * 1e9)
                if (now := _STATES.get(bus.state.name, state)) is not state:
                    state = now
                    self._tell(partial(self._user.in_state, self, state))

    def _deliver(self, batch: list[Heard]) -> None:
        self._room.release()
        self._user.heard(self, batch)

    def _send(self, bus: Any, outgoing: queue.SimpleQueue[Frame | None]) -> None:
        can = load_can()
        while (frame := outgoing.get()) is not None:
            why_not = _attempt(bus, _message(can, frame), self._closed)
            self._tell(partial(self._user.sent, self, why_not))


_STATES = {
    "ACTIVE": ErrorState.ERROR_ACTIVE,
    "PASSIVE": ErrorState.ERROR_PASSIVE,
    "ERROR": ErrorState.BUS_OFF,
}


def open_bus(port: Port, setup: Setup) -> Any:
    """can.Bus as the line is set up; raises whatever that raises, ExtraMissing without python-can."""
    can = load_can()
    known = backend(port.interface)
    arguments: dict[str, Any] = {"bitrate": setup.timing.bit_rate}
    if setup.data_timing is not None:
        arguments.update(known.fd or {})
        if known.timing:
            arguments["timing"] = _timing(can, setup.timing, setup.data_timing)
            del arguments["bitrate"]
        else:
            arguments["data_bitrate"] = setup.data_timing.bit_rate
    if setup.listen_only:
        arguments.update(known.listen_only or {})
    arguments = {
        name: can.BusState.PASSIVE if value == PASSIVE else value for name, value in arguments.items()
    }
    arguments.update(port.options)
    return can.Bus(channel=port.channel, interface=port.interface, ignore_config=True, **arguments)


def load_can() -> Any:
    """python-can, or one clear line that names the extra."""
    try:
        import can
    except ModuleNotFoundError:
        raise ExtraMissing("python-can", "hardware") from None
    return can


def _timing(can: Any, nominal: BitTiming, data: BitTiming) -> Any:
    return can.BitTimingFd(
        f_clock=nominal.clock_hz,
        nom_brp=nominal.prescaler,
        nom_tseg1=nominal.tseg1,
        nom_tseg2=nominal.tseg2,
        nom_sjw=nominal.sjw,
        data_brp=data.prescaler,
        data_tseg1=data.tseg1,
        data_tseg2=data.tseg2,
        data_sjw=data.sjw,
    )


def _heard(message: Any) -> Heard | None:
    """None for what is no frame that a bus could carry: python-can checks nothing."""
    stamp_ns, arrived_ns = int((message.timestamp or 0) * 1e9), monotonic_ns()
    if message.is_error_frame:
        return Heard(
            b"", (message.arbitration_id, bytes(message.data or b"")[:8]), max(0, stamp_ns), arrived_ns
        )
    try:
        frame = Frame(
            message.arbitration_id,
            b"" if message.is_remote_frame else bytes(message.data),
            extended=message.is_extended_id,
            remote=message.is_remote_frame,
            fd=message.is_fd,
            bit_rate_switch=message.bitrate_switch,
            error_state_indicator=message.error_state_indicator,
            dlc=min(message.dlc, 8) if message.is_remote_frame else None,
        )
    except (CanwireError, TypeError, ValueError):
        return None
    return Heard(record_of_frame(frame), None, max(0, stamp_ns), arrived_ns)


def _message(can: Any, frame: Frame) -> Any:
    return can.Message(
        arbitration_id=frame.id,
        is_extended_id=frame.extended,
        is_remote_frame=frame.remote,
        is_fd=frame.fd,
        bitrate_switch=frame.bit_rate_switch,
        error_state_indicator=frame.error_state_indicator,
        data=None if frame.remote else frame.data,
        dlc=min(frame.dlc, 8) if frame.remote else len(frame.data),
    )


def _attempt(bus: Any, message: Any, closed: threading.Event) -> str:
    """ "" once it is sent; why it is not, after a few tries: a full queue passes."""
    why_not = ""
    for pause_s in (*_TRIES_S, 0):
        try:
            bus.send(message, _SEND_S)
        except Exception as error:
            why_not = _text_of(error)
            if closed.wait(pause_s):
                break
        else:
            return ""
    return why_not


def _text_of(error: Exception) -> str:
    return str(error) or type(error).__name__
