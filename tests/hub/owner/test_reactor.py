"""What boards ask of the engine before there is one."""

from __future__ import annotations

from canwire.hub.owner.reactor import LaterReactor


class Engine:
    """It takes down what it is asked for."""

    def __init__(self) -> None:
        self.asked: list[object] = []

    def post(self, work: object) -> None:
        self.asked.append(work)


def test_it_hands_everything_on_in_order_once_the_engine_is_there() -> None:
    early, late = (lambda: None), (lambda: None)
    reactor, engine = LaterReactor(), Engine()
    assert not reactor.used
    reactor.post(early)
    assert reactor.used
    assert engine.asked == []
    reactor.attach(engine)  # type: ignore[arg-type]
    reactor.post(late)
    assert engine.asked == [early, late]
