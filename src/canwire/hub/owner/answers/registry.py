"""The function that answers each kind of request, and common forms of answers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from canwire.errors import BadMessage
from canwire.hub.owner.deferred import Deferred
from canwire.hub.owner.held.held import Held
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer

Request = TypeVar("Request", bound=m.Message)
Answering = Callable[[Request, Session, World], Answer | Deferred]

DONE: Answer = (m.Done(), ())


class Answers:
    """Functions by the kind of request; the constructor combines other Answers.

    A function gets the request, the session that sent it and the hub's world, and raises CanwireError.
    """

    def __init__(self, *parts: Answers) -> None:
        self._functions: dict[type[m.Message], Answering[Any]] = {}
        for part in parts:
            for kind, function in part._functions.items():
                self._add(kind, function)

    def to(self, kind: type[Request]) -> Callable[[Answering[Request]], Answering[Request]]:
        """Decorator: the function answers requests of this kind. Raises ValueError for a second one."""

        def add(function: Answering[Request]) -> Answering[Request]:
            self._add(kind, function)
            return function

        return add

    def answer(self, request: m.Message, session: Session, world: World) -> Answer | Deferred:
        """The answer to a request of this session; raises CanwireError."""
        function = self._functions.get(type(request))
        if function is None:
            raise BadMessage(f"{type(request).__name__} is no request for a session")
        return function(request, session, world)

    @property
    def kinds(self) -> frozenset[type[m.Message]]:
        """The kinds of requests that have a function here."""
        return frozenset(self._functions)

    def _add(self, kind: type[m.Message], function: Answering[Any]) -> None:
        if kind in self._functions:
            raise ValueError(f"{kind.__name__} has an answer already: {self._functions[kind].__name__}")
        self._functions[kind] = function


def opened(session: Session, held: Held) -> Answer:
    """Give this session a handle of the object, and return the reply."""
    return m.Opened(session.hold(held)), ()
