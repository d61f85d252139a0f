"""Node configuration and identification in a slave. No I/O; callers pass the times.

`LinSlaveConfiguration` receives master requests (0x3C) and returns the answers to the header of slave responses
(0x3D). `identifiers` maps its configurable frames to identifiers; the caller applies them to the frames.

Source: LIN 2.2A 4.2 (node configuration and identification); reference/lin-protocol.md section 10.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from canwire.errors import BadValue
from canwire.values.lin.frame import parity_holds, protected_id
from canwire.values.lin.transport import (
    BROADCAST_NAD,
    FUNCTIONAL_NAD,
    SLEEP_NAD,
    TIMEOUT_NS,
    LinMessage,
    LinReassembly,
    LinTransmission,
)

ASSIGN_NAD, ASSIGN_FRAME_ID, READ_BY_IDENTIFIER, CONDITIONAL_CHANGE_NAD = 0xB0, 0xB1, 0xB2, 0xB3
DATA_DUMP, SAVE_CONFIGURATION, ASSIGN_FRAME_ID_RANGE = 0xB4, 0xB6, 0xB7
_RESPONSE = 0x40  # RSID is SID and this
_NEGATIVE, _NOT_SUPPORTED = 0x7F, 0x12
_ANY_SUPPLIER, _ANY_FUNCTION = 0x7FFF, 0xFFFF
_UNASSIGN, _LEAVE, _NO_PID = 0x00, 0xFF, 0x40

Service = Callable[[bytes], bytes | None]


@dataclass(frozen=True, slots=True)
class LinProduct:
    """The product identification: supplier (15 bits), function (16 bits), and `variant` for the version."""

    supplier: int
    function: int
    variant: int = 0

    def __post_init__(self) -> None:
        for name, largest in (("supplier", 0x7FFE), ("function", 0xFFFE), ("variant", 0xFF)):
            if not 0 <= getattr(self, name) <= largest:
                raise BadValue(f"{name} {getattr(self, name)!r}: from 0 to {largest:#x}")

    @property
    def octets(self) -> bytes:
        """The bytes as identifier 0 returns them."""
        parts = self.supplier.to_bytes(2, "little") + self.function.to_bytes(2, "little")
        return parts + bytes([self.variant])

    def matches(self, octets: bytes) -> bool:
        """Supplier and function, four bytes of a request; wildcards match all nodes."""
        supplier, function = (int.from_bytes(octets[at : at + 2], "little") for at in (0, 2))
        return supplier in (self.supplier, _ANY_SUPPLIER) and function in (self.function, _ANY_FUNCTION)


@dataclass(frozen=True, slots=True)
class LinNodeAttributes:
    """The attributes of a slave, as in the Node_attributes of an LDF.

    `frames` are its configurable frames: identifiers by index, or by message identifier where `message_ids` (LIN 2.0).
    `serial` answers identifier 1, `identifiers` those from 32 to 63 (up to 5 bytes each). `data_dump` answers that
    service, and `service` any other request (payload in, payload or None out), `p2_ns` after the request at the
    earliest. `n_as_ns` and `n_cr_ns` are the timeouts of its transport layer. Raises BadValue.
    """

    product: LinProduct
    nad: int = 0x01
    frames: Mapping[int, int] = field(default_factory=dict)
    serial: int | None = None
    identifiers: Mapping[int, bytes] = field(default_factory=dict)
    message_ids: bool = False
    data_dump: Service | None = None
    service: Service | None = None
    p2_ns: int = 50_000_000
    n_as_ns: int = TIMEOUT_NS
    n_cr_ns: int = TIMEOUT_NS

    def __post_init__(self) -> None:
        if not 0x01 <= self.nad <= 0xFF or self.nad in (FUNCTIONAL_NAD, BROADCAST_NAD):
            raise BadValue(f"nad {self.nad!r}: from 0x01 to 0x7D, or from 0x80 to 0xFF")
        for id in self.frames.values():
            protected_id(id)
        for number, octets in self.identifiers.items():
            if not 32 <= number <= 63 or not 1 <= len(octets) <= 5:
                raise BadValue(
                    f"identifier {number}: {len(octets)} bytes; it has 1 to 5, and a number from 32 to 63"
                )


class LinSlaveConfiguration:
    """One slave's NAD and frame identifiers, as master requests change them; `nad` is its present one.

    `identifiers` are those of its configurable frames now, None for one that is unassigned.
    """

    def __init__(self, attributes: LinNodeAttributes) -> None:
        self.attributes = attributes
        self._saved: tuple[int, dict[int, int | None]] = (attributes.nad, dict(attributes.frames))
        self._requests = LinReassembly(attributes.n_cr_ns)
        self._answer: LinTransmission | None = None
        self._services: dict[int, Callable[[bytes], bytes | None]] = {
            READ_BY_IDENTIFIER: self._read,
            CONDITIONAL_CHANGE_NAD: self._change_nad,
            DATA_DUMP: self._dump,
            SAVE_CONFIGURATION: self._save,
            ASSIGN_FRAME_ID_RANGE: self._assign_range,
        }
        if attributes.message_ids:
            self._services[ASSIGN_FRAME_ID] = self._assign_frame
        self.power_up()

    def power_up(self) -> None:
        """Restart with the values saved last, or with the attributes if none were saved."""
        self.nad, identifiers = self._saved
        self.identifiers = dict(identifiers)
        self._requests.drop()
        self._answer = None

    def __repr__(self) -> str:
        frames = ", ".join(
            f"{key:#x} {'unassigned' if id is None else f'{id:#04x}'}" for key, id in self.identifiers.items()
        )
        return f"<LIN slave at NAD {self.nad:#04x}: frames {frames or 'none'}>"

    @property
    def dropped(self) -> int:
        """Number of incomplete requests: a frame was missing or late."""
        return self._requests.dropped

    @property
    def due_ns(self) -> int | None:
        """When `response` will be another by itself: the answer is ready, or is given up; None where nothing waits."""
        return None if self._answer is None else self._answer.expires_ns + 1

    @property
    def ready_ns(self) -> int | None:
        """The time from which the answer may be fetched; None if there is no answer."""
        return None if self._answer is None else self._answer.ready_ns

    def request(self, data: bytes, at_ns: int) -> None:
        """A master request, 8 bytes, that ended at this time."""
        nad = data[0]
        if nad == SLEEP_NAD:
            return
        mine = nad in (self.nad, BROADCAST_NAD, self.attributes.nad)
        if not mine and nad != FUNCTIONAL_NAD:
            self._requests.drop()
            self._answer = None  # the next slave response is another node's
            return
        if nad != FUNCTIONAL_NAD:
            self._answer = None
        message = self._requests.frame(data, at_ns)
        if message is not None:
            self._serve(message, at_ns)

    def response(self, at_ns: int) -> bytes | None:
        """The answer to the header of a slave response at this time; None: no answer."""
        return None if self._answer is None else self._answer.waiting(at_ns)

    def fetched(self, at_ns: int) -> None:
        """The response has gone out."""
        if self._answer is not None:
            self._answer.fetched(at_ns)

    # services

    def _serve(self, message: LinMessage, at_ns: int) -> None:
        sid, data = message.payload[0], message.payload[1:]
        nad, ready_ns = self.nad, at_ns
        if sid == ASSIGN_NAD:
            answer, nad = self._assign_nad(message.nad, data), self.attributes.nad
        elif message.nad == self.attributes.nad != self.nad:
            return  # the initial NAD is for assigning another one alone
        elif ASSIGN_NAD <= sid <= ASSIGN_FRAME_ID_RANGE:
            known = self._services.get(sid)
            answer = None if known is None else known(data)
            nad = self.nad  # perhaps a new one
        else:
            service, ready_ns = self.attributes.service, at_ns + self.attributes.p2_ns
            answer = None if service is None else service(message.payload)
        if answer is not None and message.nad != FUNCTIONAL_NAD:
            self._answer = LinTransmission(LinMessage(nad, answer), ready_ns, self.attributes.n_as_ns)

    def _assign_nad(self, asked: int, data: bytes) -> bytes | None:
        if asked not in (self.attributes.nad, BROADCAST_NAD) or len(data) < 5:
            return None
        if not self.attributes.product.matches(data):
            return None
        self.nad = data[4]
        return bytes([ASSIGN_NAD + _RESPONSE])

    def _assign_frame(self, data: bytes) -> bytes | None:
        if len(data) < 5 or not self.attributes.product.matches(data[:2] + b"\xff\xff"):
            return None
        if not self._assign({int.from_bytes(data[2:4], "little"): data[4]}):
            return None
        return bytes([ASSIGN_FRAME_ID + _RESPONSE])

    def _assign_range(self, data: bytes) -> bytes | None:
        if len(data) < 5 or self.attributes.message_ids:
            return None
        wanted = {data[0] + k: pid for k, pid in enumerate(data[1:5]) if pid != _LEAVE}
        return bytes([ASSIGN_FRAME_ID_RANGE + _RESPONSE]) if self._assign(wanted) else None

    def _assign(self, wanted: dict[int, int]) -> bool:
        """Assign all these identifiers; assign none of them if a frame does not exist or an identifier is invalid."""
        pids = [pid for pid in wanted.values() if pid not in (_UNASSIGN, _NO_PID)]
        if not set(wanted) <= set(self.identifiers) or not all(parity_holds(pid) for pid in pids):
            return False
        for key, pid in wanted.items():
            self.identifiers[key] = None if pid in (_UNASSIGN, _NO_PID) else pid & 0x3F
        return True

    def _read(self, data: bytes) -> bytes | None:
        if len(data) < 5 or not self.attributes.product.matches(data[1:]):
            return None
        octets = self._identified(data[0])
        if octets is None:
            return bytes([_NEGATIVE, READ_BY_IDENTIFIER, _NOT_SUPPORTED])
        return bytes([READ_BY_IDENTIFIER + _RESPONSE]) + octets

    def _change_nad(self, data: bytes) -> bytes | None:
        if len(data) < 5:
            return None
        number, at, mask, invert, nad = data[:5]
        octets = self._identified(number)
        if octets is None or not 1 <= at <= len(octets) or (octets[at - 1] ^ invert) & mask:
            return None
        self.nad = nad
        return bytes([CONDITIONAL_CHANGE_NAD + _RESPONSE])

    def _dump(self, data: bytes) -> bytes | None:
        if self.attributes.data_dump is None:
            return None
        octets = self.attributes.data_dump(data)
        return None if octets is None else bytes([DATA_DUMP + _RESPONSE]) + octets

    def _save(self, data: bytes) -> bytes:
        self._saved = (self.nad, dict(self.identifiers))
        return bytes([SAVE_CONFIGURATION + _RESPONSE])

    def _identified(self, number: int) -> bytes | None:
        attributes = self.attributes
        if number == 0:
            return attributes.product.octets
        if number == 1 and attributes.serial is not None:
            return attributes.serial.to_bytes(4, "little")
        return attributes.identifiers.get(number)
