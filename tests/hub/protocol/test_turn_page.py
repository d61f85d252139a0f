"""What a program writes for its hub in their page of memory, and the hub for the program."""

from __future__ import annotations

from canwire.hub.protocol.turn_page import SIZE, TurnPage


def test_each_end_sees_what_the_other_one_did_once() -> None:
    memory = memoryview(bytearray(SIZE))
    program, hub = TurnPage(memory), TurnPage(memory)
    assert (hub.asked(), hub.stirred(), hub.called()) == (False, False, False)
    asked = program.ask(700)
    assert (hub.asked(), hub.until_ns(), hub.stirred(), hub.called()) == (True, 700, False, False)
    program.stir()
    assert (hub.asked(), hub.stirred(), hub.called()) == (False, True, False)
    program.call()
    assert (hub.stirred(), hub.called()) == (True, True)
    assert (hub.stirred(), hub.called()) == (False, False)
    assert not program.given(asked)
    hub.give(500)
    assert (program.given(asked), program.now_ns()) == (True, 500)
