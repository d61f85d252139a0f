"""A python-can bus with two threads: one opens it and reads, one sends. Both only post results to the hub's thread.

Objects of python-can stay in this file: other files receive records of 80 bytes and times.
"""

from __future__ import annotations

import contextlib
import queue
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from canwire.drivers.obstacles import text_of
from canwire.drivers.outside import Reactor
from canwire.drivers.python_can.backends import backend
from canwire.drivers.python_can.opening import Setup, load_can, open_bus
from canwire.drivers.python_can.port import Port
from canwire.drivers.python_can.reasons import missing, reason
from canwire.errors import CanwireError, ExtraMissing
from canwire.values.event import ErrorState
from canwire.values.frame import Frame, record_of_frame

FIRST_RETRY_S, LONGEST_RETRY_S = 0.1, 5.0
_LOOK_S = 0.1  # how long a reader waits before it looks whether it is still wanted
_STATE_S = 0.5
_SEND_S = 1.0
_TRIES_S = (0.002, 0.01, 0.05)  # pauses before a frame is tried again
_BATCH, _BATCHES = 256, 8

monotonic_ns = time.monotonic_ns


class Heard(NamedTuple):
    """A message for the hub's thread: a record, or for an error frame its `error` (identifier, data).

    `own`: the adapter reports that it sent this frame itself.
    """

    record: bytes
    error: tuple[int, bytes] | None
    stamp_ns: int
    arrived_ns: int
    own: bool = False


class User:
    """Receives what happens to an `adapter`, in the hub's thread."""

    def opened(self, adapter: Adapter, what: str) -> None: ...
    def failed(self, adapter: Adapter, why: str) -> None: ...
    def lost(self, adapter: Adapter, why: str) -> None: ...
    def heard(self, adapter: Adapter, batch: list[Heard]) -> None: ...
    def sent(self, adapter: Adapter, why_not: str) -> None: ...
    def in_state(self, adapter: Adapter, state: ErrorState) -> None: ...


class Adapter:
    """Opens the bus, and opens it again after each failure until `close`."""

    def __init__(self, port: Port, setup: Setup, reactor: Reactor, user: User) -> None:
        self._port = port
        self._setup = setup
        self._reactor = reactor
        self._user = user
        self._room = threading.Semaphore(_BATCHES)
        self._closed = threading.Event()
        self._open = threading.Event()
        self._outgoing: queue.SimpleQueue[Frame | None] = queue.SimpleQueue()
        self._kind = backend(port.interface)
        threading.Thread(target=self._run, name="canwire-python-can", daemon=True).start()

    def send(self, frame: Frame) -> None:
        """Queue this frame; `User.sent` is called for each."""
        self._outgoing.put(frame)

    def close(self) -> None:
        """Close the bus; the User is not called after this."""
        self._closed.set()
        self._outgoing.put(None)

    # in the adapter's threads

    def _tell(self, work: Callable[[], object]) -> None:
        with contextlib.suppress(CanwireError):  # the hub has ended
            self._reactor.post(lambda: None if self._closed.is_set() else work())

    def _run(self) -> None:
        wait_s = FIRST_RETRY_S
        while not self._closed.is_set():
            try:
                bus = open_bus(self._port, self._setup)
            except Exception as error:  # somebody else's code: anything may come
                self._tell(partial(self._user.failed, self, reason(self._port, error)))
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
        self._open.set()
        sender.start()
        self._tell(partial(self._user.opened, self, str(getattr(bus, "channel_info", ""))))
        try:
            self._read(bus)
        except Exception as error:
            why = f"the adapter was unplugged, or has failed ({text_of(error)})"
            self._tell(partial(self._user.lost, self, why))
            self._closed.wait(FIRST_RETRY_S)
        finally:
            outgoing, self._outgoing = self._outgoing, queue.SimpleQueue()
            self._open.clear()
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
        can = None if self._kind.ours else load_can()
        while (frame := outgoing.get()) is not None:
            message = frame if can is None else _message(can, frame)
            why_not = _attempt(bus, message, self._closed)
            if self._kind.ours and not why_not:
                why_not = self._confirmed(bus)
            self._tell(partial(self._user.sent, self, why_not))

    def _confirmed(self, bus: Any) -> str:
        """Wait until the frame was on the bus, or the adapter is gone; returns why it was not sent, or ""."""
        while not bus.sent(_LOOK_S):
            if self._closed.is_set() or not self._open.is_set():
                return "the adapter was closed before the bus took the frame"
        return ""


_STATES = {
    "ACTIVE": ErrorState.ERROR_ACTIVE,
    "PASSIVE": ErrorState.ERROR_PASSIVE,
    "ERROR": ErrorState.BUS_OFF,
}


def look(port: Port, reactor: Reactor, tell: Callable[[str], object]) -> None:
    """Call `tell` in the hub's thread with the reason why this adapter cannot be opened; "" if none is known yet."""

    def find() -> None:
        why = missing(port)
        with contextlib.suppress(CanwireError):  # the hub has ended
            reactor.post(partial(tell, why))

    threading.Thread(target=find, name="canwire-python-can", daemon=True).start()


def _heard(message: Any) -> Heard | None:
    """None for a message that no bus could carry: python-can does not check that."""
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
    return Heard(record_of_frame(frame), None, max(0, stamp_ns), arrived_ns, not message.is_rx)


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
    """Send a message in a few tries, since a queue may be full for a moment; returns why it failed, or ""."""
    why_not = ""
    for pause_s in (*_TRIES_S, 0):
        try:
            bus.send(message, _SEND_S)
        except Exception as error:
            why_not = text_of(error)
            if closed.wait(pause_s):
                break
        else:
            return ""
    return why_not
