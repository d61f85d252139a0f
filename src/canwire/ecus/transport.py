"""can-isotp on a node of the lab: its state machine, with the lab's time in place of the wall clock.

Source: can-isotp 2.0 (TransportLayerLogic, tools.Timer); ISO 15765-2.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import isotp
from isotp.protocol import TransportLayerLogic
from isotp.tools import Timer

from canwire import Frame, LabNode

_TURN_NS = 500_000  # while a message is on its way: how often its timeouts are looked at
_MS = 1000


class _LabTimer(Timer):
    """A timer for can-isotp that counts the lab's time."""

    def __init__(self, timeout: float, now_ns: Callable[[], int]) -> None:
        super().__init__(timeout)
        self._now_ns = now_ns

    def start(self, timeout: float | None = None) -> None:
        if timeout is not None:
            self.set_timeout(timeout)
        self.start_time = self._now_ns()

    def elapsed(self) -> float:
        return self.elapsed_ns() / 1e9

    def elapsed_ns(self) -> int:
        return 0 if self.start_time is None else self._now_ns() - self.start_time


class _LabLogic(TransportLayerLogic):
    """The state machine, with timers that count the lab's time."""

    now_ns: Callable[[], int]

    def _start_rx_fc_timer(self) -> None:
        self.timer_rx_fc = _LabTimer(float(self.params.rx_flowcontrol_timeout) / _MS, self.now_ns)
        self.timer_rx_fc.start()

    def _start_rx_cf_timer(self) -> None:
        self.timer_rx_cf = _LabTimer(float(self.params.rx_consecutive_frame_timeout) / _MS, self.now_ns)
        self.timer_rx_cf.start()


class LabIsoTp:
    """ISO-TP messages of up to 4 GB through `node`, whose frames are all used; `address` and `params` are can-isotp's.

    While the bus runs, `on_message` gets each complete message; without it, `receive` returns them. `errors` are
    can-isotp's errors, in order: timeouts, wrong sequence numbers.
    """

    def __init__(
        self,
        node: LabNode,
        address: isotp.Address,
        on_message: Callable[[bytes], None] | None = None,
        params: dict[str, Any] | None = None,
    ) -> None:
        self.node = node
        self.errors: list[Exception] = []
        self._on_message = on_message
        self._due = False
        self._logic = _LabLogic(self._take, self._put, address, self.errors.append, params)
        self._logic.now_ns = lambda: node.time.now_ns
        self._logic.timer_tx_stmin = _LabTimer(0, self._logic.now_ns)
        node.on_frames(self._wake)

    def send(self, message: bytes) -> None:
        """Queue a message."""
        self._logic.send(message)
        self._wake()

    def receive(self, timeout: float = 0.0) -> bytes | None:
        """The oldest message; None if none is complete after `timeout` seconds of the lab's time."""
        time = self.node.time
        deadline_ns = time.now_ns + round(timeout * 1e9)
        while not self._logic.available() and time.now_ns < deadline_ns:
            time.run_until(min(deadline_ns, time.now_ns + _TURN_NS))
        message = self._logic.recv()
        return None if message is None else bytes(message)

    @property
    def sending(self) -> bool:
        """Whether a message is being sent or waits to be sent."""
        return bool(self._logic.transmitting())

    def reset(self) -> None:
        """Discard unfinished messages in both directions."""
        self._logic.reset()

    def __repr__(self) -> str:
        state = f"{self._logic.tx_state.name} sending, {self._logic.rx_state.name} receiving"
        return f"<ISO-TP on {self.node.line.name}: {state}, {len(self.errors)} errors>"

    def _wake(self) -> None:
        if not self._due:
            self._due = True
            self.node.time.at(self.node.time.timeline.now_ns, self._turn)

    def _turn(self) -> None:
        self._due = False
        self._logic.process()
        while self._on_message is not None and (message := self._logic.recv()) is not None:
            self._on_message(bytes(message))
        if not self._due and (self._logic.transmitting() or self._logic.is_rx_active()):
            self._due = True
            self.node.time.at(self.node.time.timeline.now_ns + _TURN_NS, self._turn)

    def _take(self, timeout: float) -> isotp.CanMessage | None:
        frame = self.node.receive()
        if frame is None:
            return None
        return isotp.CanMessage(
            frame.id,
            frame.dlc,
            frame.data,
            extended_id=frame.extended,
            is_fd=frame.fd,
            bitrate_switch=frame.bit_rate_switch,
        )

    def _put(self, message: isotp.CanMessage) -> None:
        self.node.send(
            Frame(
                message.arbitration_id,
                bytes(message.data),
                extended=message.is_extended_id,
                fd=message.is_fd,
                bit_rate_switch=message.bitrate_switch,
            )
        )
