"""Every kind of request has one answer."""

from __future__ import annotations

import gc
from typing import get_args

import pytest

from canwire.boards.config.configuration import Config
from canwire.errors import BadFrame, BadMessage
from canwire.hub.owner.answers.everything import ANSWERS
from canwire.hub.owner.answers.registry import DONE, Answers
from canwire.hub.owner.entrance import open_session
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.fault_messages import Noise
from canwire.hub.protocol.lin_messages import LinRequest, WriteLin
from canwire.hub.protocol.link import Answer
from canwire.timeline import Timer
from canwire.values.record import RECORD_SIZE


def test_every_request_but_the_links_own_hello_has_an_answer() -> None:
    assert frozenset(get_args(m.Request | LinRequest)) - {m.Hello} == ANSWERS.kinds


def test_a_request_without_an_answer_says_so() -> None:
    world = World(Config.default(), virtual=True)
    session = open_session(world, "one", 1, lambda notice: None, None)
    with pytest.raises(BadMessage, match="Hello is no request for a session"):
        session.handle(m.Hello(m.VERSION, 1, "again"))


def test_two_answers_to_one_request_are_refused() -> None:
    one, two = Answers(), Answers()

    @one.to(m.Watch)
    def watch(request: m.Watch, session: Session, world: World) -> Answer:
        return DONE

    two.to(m.Watch)(watch)
    with pytest.raises(ValueError, match="Watch has an answer already: watch"):
        one.to(m.Watch)(watch)
    with pytest.raises(ValueError, match="Watch has an answer already: watch"):
        Answers(one, two)
    assert Answers(one).kinds == {m.Watch}


def test_waits_that_are_over_leave_nothing_for_later() -> None:
    """A client that waits for a fault until next year and takes the fault back, again and again."""
    world = World(Config.default(), virtual=True)
    session = open_session(world, "one", 1, lambda notice: None, None)
    before = _due()
    for _ in range(500):
        reply = session.handle(m.SetFault("can0", Noise(1e-9), None, False))
        assert isinstance(reply, tuple)
        (opened, _) = reply
        assert isinstance(opened, m.Opened)
        session.handle(m.AwaitFault(opened.handle, 10**17))
        session.handle(m.CancelFault(opened.handle))
        session.handle(m.Close(opened.handle))
    world.timeline.run_until(world.timeline.now_ns + 1)
    assert _due() - before < 10


def _due() -> int:
    return sum(type(found) is Timer and found.callback is not None for found in gc.get_objects())


def test_a_lin_record_of_another_size_is_the_programs_mistake() -> None:
    session = open_session(World(Config.default(), virtual=True), "one", 1, lambda notice: None, None)
    with pytest.raises(BadFrame, match=rf"a record has {RECORD_SIZE} bytes, not 5"):
        session.handle(WriteLin(1, bytes(5), False))
