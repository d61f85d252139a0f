"""A small ECU with UDS: sessions, identifiers, security access, a flash download.

Requests and responses use udsoncan, messages use can-isotp; this file contains the behaviour of an ECU.
Source: ISO 14229-1:2020, 9 to 14; negative response codes in its annex A.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import isotp
from udsoncan.Request import Request
from udsoncan.Response import Response

from canwire import LabNode, Timer
from canwire.ecus.transport import LabIsoTp

_S = 1_000_000_000
_S3_NS = 5 * _S  # a session other than the default one ends after this much silence
_LOCKED_NS = 10 * _S  # after three wrong keys
_ANSWER_NS = 1_000_000
_P2 = bytes.fromhex("0032 01F4")  # 50 ms, and 5 s after "response pending"
_BLOCK = 0x102  # the longest TransferData request: two bytes of header and 256 of data
_DEFAULT, _PROGRAMMING, _EXTENDED = 1, 2, 3
_TRIES = 3

Code = Response.Code
Handler = Callable[["UdsEcu", Request], bytes]


class Refused(Exception):
    """A negative response, with its code."""

    def __init__(self, code: int) -> None:
        super().__init__(code)  # pickle calls `__init__` with these arguments
        self.code = code

    def __str__(self) -> str:
        return str(Code.get_name(self.code))


def inverted(seed: bytes) -> bytes:
    """The default key of this ECU: the seed with all bits inverted."""
    return bytes(each ^ 0xFF for each in seed)


class UdsEcu:
    """A node's behaviour: `bus.node("ecu", UdsEcu(identifiers={0xF190: b"..."}))`.

    Any client can read `identifiers`; those in `writable` can be written in the extended session once the ECU is
    unlocked. `key` returns the right key for a seed. In the programming session, once the ECU is unlocked, `memory`
    (from address `base` on) is written by RequestDownload, TransferData and RequestTransferExit. `extended` are the
    bytes before requests and responses in extended addressing. `session`, `unlocked` and `resets` are the ECU's state.
    """

    unlocked: bool
    session: int

    def __init__(
        self,
        *,
        identifiers: Mapping[int, bytes] | None = None,
        writable: tuple[int, ...] = (),
        key: Callable[[bytes], bytes] = inverted,
        memory: int = 65_536,
        base: int = 0x0800_0000,
        request: int = 0x7E0,
        response: int = 0x7E8,
        extended: tuple[int, int] | None = None,
    ) -> None:
        self.identifiers = dict(identifiers or {})
        self.writable = writable
        self.memory = bytearray(b"\xff" * memory)
        self.base = base
        self.resets = 0
        self._key = key
        mine, testers = extended or (None, None)
        modes = isotp.AddressingMode
        self._address = isotp.Address(
            modes.Normal_11bits if extended is None else modes.Extended_11bits,
            txid=response,
            rxid=request,
            source_address=mine,
            target_address=testers,
        )
        self._silence: Timer | None = None
        self._wrong_keys = 0
        self._locked_until_ns = 0
        self._seeds = 0
        self._fall_back()

    def run_on(self, node: LabNode) -> None:
        """Start on this node; `bus.node` does it."""
        self.node = node
        self.transport = LabIsoTp(node, self._address, self._asked)

    def __repr__(self) -> str:
        return f"<UDS ECU: session {self.session}, {'unlocked' if self.unlocked else 'locked'}, {self.resets} resets>"

    def answer(self, payload: bytes) -> bytes | None:
        """The response to a request; None if no response is wanted."""
        request = Request.from_payload(payload)
        if request.service is None:
            return bytes([0x7F, *payload[:1], Code.ServiceNotSupported])
        try:
            handler = HANDLERS.get(payload[0])
            if handler is None:
                raise Refused(Code.ServiceNotSupported)
            data = handler(self, request)
        except Refused as refusal:
            return Response(request.service, refusal.code).get_payload()
        if request.suppress_positive_response:
            return None
        return Response(request.service, Code.PositiveResponse, data).get_payload()

    # services

    def _control_session(self, request: Request) -> bytes:
        if request.subfunction not in (_DEFAULT, _PROGRAMMING, _EXTENDED):
            raise Refused(Code.SubFunctionNotSupported)
        self._fall_back()
        self.session = request.subfunction
        return bytes([self.session]) + _P2

    def _reset(self, request: Request) -> bytes:
        if request.subfunction not in (1, 2, 3):
            raise Refused(Code.SubFunctionNotSupported)
        self.resets += 1
        self._fall_back()
        return bytes([request.subfunction])

    def _present(self, request: Request) -> bytes:
        if request.subfunction != 0:
            raise Refused(Code.SubFunctionNotSupported)
        return b"\0"

    def _read(self, request: Request) -> bytes:
        asked = _data(request)
        if not asked or len(asked) % 2:
            raise Refused(Code.IncorrectMessageLengthOrInvalidFormat)
        wanted = [int.from_bytes(asked[place : place + 2], "big") for place in range(0, len(asked), 2)]
        there = [id.to_bytes(2, "big") + self.identifiers[id] for id in wanted if id in self.identifiers]
        if not there:
            raise Refused(Code.RequestOutOfRange)
        return b"".join(there)

    def _write(self, request: Request) -> bytes:
        told = _data(request)
        if len(told) < 3:
            raise Refused(Code.IncorrectMessageLengthOrInvalidFormat)
        id = int.from_bytes(told[:2], "big")
        if id not in self.writable:
            raise Refused(Code.RequestOutOfRange)
        if self.session != _EXTENDED:
            raise Refused(Code.ServiceNotSupportedInActiveSession)
        if not self.unlocked:
            raise Refused(Code.SecurityAccessDenied)
        self.identifiers[id] = told[2:]
        return told[:2]

    def _access(self, request: Request) -> bytes:
        """Security access, level 1: the client requests a seed (1), then sends its key (2)."""
        if self.session == _DEFAULT:
            raise Refused(Code.ServiceNotSupportedInActiveSession)
        if request.subfunction == 1:
            if self.node.time.now_ns < self._locked_until_ns:
                raise Refused(Code.RequiredTimeDelayNotExpired)
            self._seeds += 1
            self._seed = b"" if self.unlocked else (0x5A17_0000 + self._seeds * 0x3D).to_bytes(4, "big")
            return b"\1" + (self._seed or bytes(4))  # zeros: it is unlocked
        if request.subfunction != 2:
            raise Refused(Code.SubFunctionNotSupported)
        return self._check_key(_data(request))

    def _check_key(self, key: bytes) -> bytes:
        seed, self._seed = self._seed, b""
        if not seed:
            raise Refused(Code.RequestSequenceError)
        if key == self._key(seed):
            self.unlocked, self._wrong_keys = True, 0
            return b"\2"
        self._wrong_keys += 1
        if self._wrong_keys < _TRIES:
            raise Refused(Code.InvalidKey)
        self._wrong_keys, self._locked_until_ns = 0, self.node.time.now_ns + _LOCKED_NS
        raise Refused(Code.ExceedNumberOfAttempts)

    def _download(self, request: Request) -> bytes:
        self._check_programming()
        told = _data(request)
        if len(told) < 2 or len(told) != 2 + (told[1] & 15) + (told[1] >> 4):
            raise Refused(Code.IncorrectMessageLengthOrInvalidFormat)
        border = 2 + (told[1] & 15)
        start = int.from_bytes(told[2:border], "big") - self.base
        end = start + int.from_bytes(told[border:], "big")
        if told[0] or start < 0 or end > len(self.memory):
            raise Refused(Code.RequestOutOfRange)
        self._next, self._end, self._block = start, end, 1
        return b"\x20" + _BLOCK.to_bytes(2, "big")

    def _transfer(self, request: Request) -> bytes:
        self._check_programming()
        if self._end < 0:
            raise Refused(Code.RequestSequenceError)
        told = _data(request)
        if not 2 <= len(told) < _BLOCK:
            raise Refused(Code.IncorrectMessageLengthOrInvalidFormat)
        if told[0] != self._block:
            raise Refused(Code.WrongBlockSequenceCounter)
        if self._next + len(told) - 1 > self._end:
            raise Refused(Code.TransferDataSuspended)
        self.memory[self._next : self._next + len(told) - 1] = told[1:]
        self._next += len(told) - 1
        self._block = (self._block + 1) & 0xFF
        return told[:1]

    def _exit(self, request: Request) -> bytes:
        self._check_programming()
        if self._end < 0 or self._next != self._end:
            raise Refused(Code.RequestSequenceError)
        self._end = -1
        return b""

    # inside

    def _check_programming(self) -> None:
        if self.session != _PROGRAMMING:
            raise Refused(Code.ServiceNotSupportedInActiveSession)
        if not self.unlocked:
            raise Refused(Code.SecurityAccessDenied)

    def _asked(self, payload: bytes) -> None:
        answer = self.answer(payload)
        if self._silence is not None:
            self._silence.cancel()
        time = self.node.time
        self._silence = time.at(time.timeline.now_ns + _S3_NS, self._fall_back, background=True)
        if answer is not None:
            sent: bytes = answer
            time.at(time.timeline.now_ns + _ANSWER_NS, lambda: self.transport.send(sent))

    def _fall_back(self) -> None:
        """Return to the default session: locked, without a download."""
        self.session = _DEFAULT
        self.unlocked = False
        self._seed = b""
        self._next, self._end, self._block = 0, -1, 1


def _data(request: Request) -> bytes:
    return bytes(request.data or b"")


HANDLERS: dict[int, Handler] = {  # by service identifier
    0x10: UdsEcu._control_session,
    0x11: UdsEcu._reset,
    0x22: UdsEcu._read,
    0x27: UdsEcu._access,
    0x2E: UdsEcu._write,
    0x34: UdsEcu._download,
    0x36: UdsEcu._transfer,
    0x37: UdsEcu._exit,
    0x3E: UdsEcu._present,
}
