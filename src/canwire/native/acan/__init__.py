"""ACAN for programs in C: answers libacan's calls by canwire.acan.api, which defines the rules and the results.

A result is 0, or 1 for a failure. ../acanapi/acan_core.h has the same formats in C.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Callable

from canwire import BadValue
from canwire.acan import ACANHI, ACANMB, ACANMBSZ, api
from canwire.native.acan.blocks import Block, Blocks
from canwire.native.helper.answers import Objects, Reply
from canwire.native.helper.rings import States

_NEW_LIBRARY = struct.Struct("<2I")  # this process, and whether nothing is registered
_MESSAGE = struct.Struct("<I")  # priority; the message follows, if there is one
_BUFFER = struct.Struct("<2I")  # room for so many messages, and whether there is a buffer
_MOST_MESSAGES = 4096  # of one answer
_FAILED = Reply(1)


class AcanAnswers:
    """canwire.acan for one program (helper.answers.Answers)."""

    def __init__(self) -> None:
        self._blocks = Blocks()
        self._objects = Objects()

    def answer(self, method: str, number: int, data: bytes) -> Reply:
        try:
            return _METHODS[method](self, number, data)
        except BadValue:  # a block of another thread's, which is registered no more
            return _FAILED

    def init(self, number: int, data: bytes) -> Reply:
        """ACAN_Init; it starts another driver if the previous one is lost."""
        is_new = api.ACAN_GetDriverVersion() == 0
        version = api.ACAN_Init()
        if is_new:
            self._forget()
        return Reply(0, version, _NEW_LIBRARY.pack(os.getpid(), is_new))

    def get_driver_version(self, number: int, data: bytes) -> Reply:
        return Reply(0, api.ACAN_GetDriverVersion())

    def get_init_status(self, number: int, data: bytes) -> Reply:
        return Reply(0, api.ACAN_GetInitStatus())

    def set_hard_config(self, number: int, data: bytes) -> Reply:
        return _succeeded(bool(data) and api.ACAN_SetHardConfig(ACANHI.unpack(data)))

    def get_hard_config(self, number: int, data: bytes) -> Reply:
        hi = ACANHI()
        return Reply(data=hi.pack()) if api.ACAN_GetHardConfig(hi) else _FAILED

    def bus_control(self, number: int, data: bytes) -> Reply:
        return Reply(0, api.ACAN_BusControl(int.from_bytes(data, "little")))

    def register(self, number: int, data: bytes) -> Reply:
        """Reply with the block's number and the driver's fields of the block."""
        block = Block(self._blocks, data)
        if not api.ACAN_Register(block.fields):
            return _FAILED
        made = self._objects.add(block)
        return Reply(0, made, block.numbered(made))

    def ack_event(self, number: int, data: bytes) -> Reply:
        block = self._objects.get(number, Block)
        return Reply(0, api.ACAN_AckEventCheck(block.fields), block.shown())

    def deregister(self, number: int, data: bytes) -> Reply:
        block = self._objects.get(number, Block)
        done = api.ACAN_Deregister(block.fields)
        self._objects.remove(number)
        self._blocks.forget(block)
        return _succeeded(done)

    def send_message(self, number: int, data: bytes) -> Reply:
        [priority] = _MESSAGE.unpack_from(data)
        message = data[_MESSAGE.size :]
        return _succeeded(bool(message) and api.ACAN_SendMessage(ACANMB.unpack(message), priority))

    def retrieve_messages(self, number: int, data: bytes) -> Reply:
        """Reply with the number of messages, the driver's fields of the block, and the messages."""
        fields = (block := self._objects.get(number, Block)).fields
        count, given = _BUFFER.unpack(data)
        fields.wCount = min(count, _MOST_MESSAGES)
        fields.lpBuf = buffer = bytearray(fields.wCount * ACANMBSZ) if given else None
        got = api.ACAN_RetrieveMessages(fields)
        if got < 0 or buffer is None:
            return _FAILED
        return Reply(0, got, block.shown() + bytes(buffer[: got * ACANMBSZ]))

    def wait(self, number: int, data: bytes) -> Reply:
        """Reply with the blocks that have changed since the last call; with a failure after ACAN_Exit."""
        changed = self._blocks.wait()
        return _FAILED if changed is None else Reply(data=changed)

    def moved(self, number: int, data: bytes) -> Reply:
        """Reply with the data that the block's channels have received."""
        return Reply(data=self._objects.get(number, Block).take_moved())

    def exit(self, number: int, data: bytes) -> Reply:
        api.ACAN_Exit()
        self._forget()
        return Reply()

    def _forget(self) -> None:
        self._blocks.end()
        self._blocks, self._objects = Blocks(), Objects()


def _succeeded(done: bool) -> Reply:
    return Reply() if done else _FAILED


_METHODS: dict[str, Callable[[AcanAnswers, int, bytes], Reply]] = {
    "init": AcanAnswers.init,
    "get_driver_version": AcanAnswers.get_driver_version,
    "get_init_status": AcanAnswers.get_init_status,
    "set_hard_config": AcanAnswers.set_hard_config,
    "get_hard_config": AcanAnswers.get_hard_config,
    "bus_control": AcanAnswers.bus_control,
    "register": AcanAnswers.register,
    "ack_event": AcanAnswers.ack_event,
    "deregister": AcanAnswers.deregister,
    "send_message": AcanAnswers.send_message,
    "retrieve_messages": AcanAnswers.retrieve_messages,
    "wait": AcanAnswers.wait,
    "moved": AcanAnswers.moved,
    "exit": AcanAnswers.exit,
}


def interface(states: States) -> AcanAnswers:
    """Return the answers for the helper; ACAN's programs use no rings."""
    return AcanAnswers()
