"""VCI V4 for programs in C++: answers the library's calls by canwire.vci, which defines rules and result codes.

The name of a method is a class and method of canwire.vci ("CanControl.init_line"), or a function of it.
"""

from __future__ import annotations

import threading
from typing import Any

import canwire
from canwire import CanwireError, Event, vci
from canwire.native.helper.answers import Objects, Passing, Reply
from canwire.native.vci.arguments import FUNCTIONS, METHODS, unpacked
from canwire.vci.fifo.elements import CAN_MSG2S, CAN_MSGS, CLASSIC_CAN_MSG2S, LIN_MSGS
from canwire.vci.fifo.fifo import FifoEnd
from canwire.vci.structures.structure import Structure
from canwire.vci.translation import as_vci_error
from canwire.vci.unknown import Unknown

_PLAIN = 0
_FORMS = {
    id(CAN_MSGS): 1,
    id(CAN_MSG2S): 2,
    id(CLASSIC_CAN_MSG2S): 3,
    id(LIN_MSGS): 4,
}  # enum form of vci/fifo.h
_WORD = 4


class VciAnswers:
    """canwire.vci for one program (helper.answers.Answers)."""

    def __init__(self, states: Passing) -> None:
        self._states = states
        self._objects = Objects()
        self._watching: dict[int, Event] = {}
        self._connecting = threading.Lock()
        self._hub: canwire.Hub | None = None

    def answer(self, method: str, number: int, data: bytes) -> Reply:
        try:
            own = _OWN.get(method)
            if own is not None:
                return own(self, number, data)
            if method in FUNCTIONS:
                self.initialize(
                    0, b""
                )  # public programs leave VciInitialize out: the vendor's library does without
                return self._reply(getattr(vci, method)(*unpacked(FUNCTIONS[method], data)))
            kind, _, name = method.partition(".")
            found: Any = self._objects.get(number, getattr(vci, kind))
            return self._reply(getattr(found, name)(*unpacked(METHODS[method], data)))
        except CanwireError as error:
            return Reply(as_vci_error(error).hresult)

    def initialize(self, number: int, data: bytes) -> Reply:
        """VciInitialize: the connection of this program; a new one if the hub of the previous one is gone."""
        with self._connecting:  # objects of a connection that is gone say so themselves
            if self._hub is None or self._hub.lost:
                self._hub = canwire.connect()
                self._hub.lends = True
                vci.initialize(self._hub)
        return Reply()

    def format_error(self, number: int, data: bytes) -> Reply:
        """VciFormatError: the text for this result code."""
        return Reply(data=vci.format_error(int.from_bytes(data, "little")).encode("latin-1", "replace"))

    def release(self, number: int, data: bytes) -> Reply:
        """Close an object, whose last reference was released."""
        found = self._objects.remove(number)
        if isinstance(found, Unknown):
            found.release()
        self._watching.pop(number, None)
        return Reply()

    def watch(self, number: int, data: bytes) -> Reply:
        """IVciEnumDevice.AssignEvent: a descriptor that becomes readable when a board is plugged in or out."""
        devices = self._objects.get(number, vci.VciEnumDevice)
        if data:
            self._watching[number] = event = Event()
            devices.assign_event(event)
            return self._states.watch(event)
        devices.assign_event(None)
        self._watching.pop(number, None)
        return Reply()

    def _reply(self, result: object) -> Reply:
        if isinstance(result, tuple):  # create_fifo's
            vciid, made = result
            reply = self._reply(made)
            return reply._replace(data=reply.data + vciid.to_bytes())
        if isinstance(result, FifoEnd):
            form = _FORMS.get(id(result.form), _PLAIN)
            return self._states.lend(result.end, self._objects.add(result), form.to_bytes(_WORD, "little"))
        if isinstance(result, Unknown):
            return Reply(value=self._objects.add(result))
        if isinstance(result, Structure):
            return Reply(data=result.to_bytes())
        if isinstance(result, list):
            return Reply(value=len(result), data=b"".join(one.to_bytes() for one in result))
        return Reply(value=int(result or 0)) if isinstance(result, int) else Reply()


_OWN = {
    "initialize": VciAnswers.initialize,
    "format_error": VciAnswers.format_error,
    "release": VciAnswers.release,
    "watch": VciAnswers.watch,
}


def interface(states: Passing) -> VciAnswers:
    """Return the answers for the helper."""
    return VciAnswers(states)
