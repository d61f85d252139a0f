"""One channel of a gs_usb adapter, with the methods of python-can's buses that adapter.py calls.

A frame counts as sent once its echo has arrived: the adapter returns each frame that it has sent on the bus.
"""

from __future__ import annotations

import errno
import threading
from dataclasses import dataclass, field
from typing import Any

from canwire.drivers.python_can.gs_usb.devices import release
from canwire.drivers.python_can.gs_usb.protocol import (
    BYTE_ORDER,
    ENDPOINT_IN,
    ENDPOINT_OUT,
    LONGEST_FRAME,
    NOT_AN_ECHO,
    VENDOR_IN,
    VENDOR_OUT,
    Abilities,
    Ability,
    Received,
    Request,
    abilities_of,
    channels_of,
    data_limits_of,
    frame_bytes,
    mode_bytes,
    received_of,
    timing_bytes,
)
from canwire.errors import BadValue, Unsupported
from canwire.values.frame import Frame
from canwire.values.timing.bit_timing import BitTiming

_WRITE_MS = 1000
_NO_TIME = {errno.ETIMEDOUT, errno.EAGAIN}
_CRTL, _RX_OVERFLOW = 0x4, b"\0\1\0\0\0\0\0\0"  # an error frame that says that frames were lost
_WRAP_US = 1 << 32


@dataclass(frozen=True, slots=True)
class Opening:
    """Arguments for opening a channel: its number on the device, and the bit timings of the hub's line."""

    timing: BitTiming
    data_timing: BitTiming | None = None
    listen_only: bool = False
    port: int = 0
    detach: bool = False


@dataclass(frozen=True, slots=True)
class Message:
    """A received message with the fields of python-can's Message; `is_rx` is False for an echo."""

    timestamp: float
    arbitration_id: int
    data: bytes
    is_error_frame: bool = False
    is_extended_id: bool = False
    is_remote_frame: bool = False
    is_fd: bool = False
    bitrate_switch: bool = False
    error_state_indicator: bool = False
    dlc: int = 0
    is_rx: bool = True


@dataclass(slots=True)
class _Clock:
    """The adapter's microseconds without the wrap every 71 minutes."""

    last_us: int = field(default=0)

    def seconds(self, stamp_us: int | None) -> float:
        if stamp_us is None:
            return 0.0
        self.last_us += ((stamp_us - self.last_us + _WRAP_US // 2) % _WRAP_US) - _WRAP_US // 2
        return self.last_us / 1e6


class GsUsbBus:
    """Opens an adapter, which then takes part in its bus; raises OSError, Unsupported, BadValue, BadTiming."""

    def __init__(self, device: Any, opening: Opening) -> None:
        self._device = device
        self._opening = opening
        self._clock = _Clock()
        self._waiting: Message | None = None  # what came along with the one before
        self._echoed = threading.Event()
        self._sent = 0  # the echo number of the frame on its way
        self._take()
        try:
            self._set_up()
        except BaseException:
            self._release()
            raise

    @property
    def channel_info(self) -> str:
        return f"gs_usb channel {self._opening.port}"

    def send(self, frame: Frame, timeout_s: float = 0.0) -> None:
        """Pass one frame to the adapter; `sent` reports when it was on the bus. Raises OSError."""
        self._sent = (self._sent + 1) % 10  # Linux numbers ten; adapters remember at least so many
        self._echoed.clear()
        self._device.write(
            ENDPOINT_OUT, frame_bytes(frame, self._sent, self._opening.port), timeout=_WRITE_MS
        )

    def sent(self, timeout_s: float) -> bool:
        """True if the echo of the last frame arrives within this time."""
        return self._echoed.wait(timeout_s)

    def recv(self, timeout_s: float) -> Message | None:
        """The next message; None after `timeout_s`. Raises OSError if the adapter was unplugged."""
        if self._waiting is not None:
            message, self._waiting = self._waiting, None
            return message
        try:
            packet = bytes(
                self._device.read(ENDPOINT_IN, LONGEST_FRAME, timeout=max(1, int(timeout_s * 1000)))
            )
        except OSError as error:
            if error.errno in _NO_TIME:
                return None
            raise
        received = received_of(packet)
        if received is None or received.channel != self._opening.port:
            return None
        return self._message(received)

    def shutdown(self) -> None:
        """Leave the bus and release the adapter; no effect if it was unplugged."""
        try:
            self._control(Request.MODE, mode_bytes(False))
        except OSError:
            return
        finally:
            self._release()

    def _message(self, received: Received) -> Message:
        at_s = self._clock.seconds(received.stamp_us)
        echo = received.echo != NOT_AN_ECHO
        if echo and received.echo == self._sent:
            self._echoed.set()
        lost = Message(at_s, _CRTL, _RX_OVERFLOW, is_error_frame=True)
        if received.frame is None:
            assert received.error is not None
            message = Message(at_s, *received.error, is_error_frame=True)
        else:
            frame = received.frame
            message = Message(
                at_s,
                frame.id,
                frame.data,
                is_extended_id=frame.extended,
                is_remote_frame=frame.remote,
                is_fd=frame.fd,
                bitrate_switch=frame.bit_rate_switch,
                error_state_indicator=frame.error_state_indicator,
                dlc=frame.dlc,
                is_rx=not echo,
            )
        if received.overflow:
            self._waiting = message
            return lost
        return message

    def _take(self) -> None:
        """Detach Linux's driver if it has the adapter; raises OSError unless that was requested."""
        attached = getattr(self._device, "is_kernel_driver_active", None)
        try:
            taken = attached is not None and bool(attached(0))
        except NotImplementedError:  # systems without such drivers
            taken = False
        if taken:
            if not self._opening.detach:
                raise OSError(
                    errno.EBUSY,
                    "Linux's gs_usb has this adapter as a network interface: share that (python-can:socketcan/can0), "
                    "or add ?detach=true to detach Linux's driver",
                )
            self._device.detach_kernel_driver(0)

    def _release(self) -> None:
        release(self._device)

    def _set_up(self) -> None:
        opening = self._opening
        self._control(Request.HOST_FORMAT, BYTE_ORDER, value=1, index=0)
        count = channels_of(self._ask(Request.CONFIGURATION, 12))
        if opening.port >= count:
            raise BadValue(f"port {opening.port}: this adapter has the channels 0 to {count - 1}")
        self._control(Request.MODE, mode_bytes(False))
        can = abilities_of(self._ask(Request.LIMITS, 40))
        flags = self._flags(can)
        self._control(Request.BIT_TIMING, timing_bytes(_timing(opening.timing, can.clock_hz, can.nominal)))
        if opening.data_timing is not None:
            limits = can.nominal
            if can.flags & Ability.DATA_LIMITS:
                limits = data_limits_of(self._ask(Request.DATA_LIMITS, 72))
            timing = _timing(opening.data_timing, can.clock_hz, limits)
            self._control(Request.DATA_BIT_TIMING, timing_bytes(timing))
        self._control(Request.MODE, mode_bytes(True, flags))

    def _flags(self, can: Abilities) -> int:
        """The flags of the mode: those for the line, and time stamps and error reports if the adapter has them."""
        flags = can.flags & (Ability.STAMPS | Ability.BUS_ERRORS)
        for wanted, ability, what in (
            (self._opening.data_timing is not None, Ability.FD, "CAN FD"),
            (self._opening.listen_only, Ability.LISTEN_ONLY, "listening only"),
        ):
            if wanted and not can.flags & ability:
                raise Unsupported(f"this gs_usb adapter does not know {what}")
            flags |= ability if wanted else 0
        return flags

    def _control(self, request: Request, data: bytes, value: int | None = None, index: int = 0) -> None:
        channel = self._opening.port if value is None else value
        self._device.ctrl_transfer(VENDOR_OUT, request, channel, index, data)

    def _ask(self, request: Request, length: int) -> bytes:
        return bytes(self._device.ctrl_transfer(VENDOR_IN, request, self._opening.port, 0, length))


def _timing(wanted: BitTiming, clock_hz: int, limits: Any) -> BitTiming:
    """The same bit rate and, as nearly as its registers can, the same sample point by the adapter's own clock."""
    return BitTiming.for_bit_rate(wanted.bit_rate, wanted.sample_point, clock_hz=clock_hz, limits=limits)
