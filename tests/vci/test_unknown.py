"""IUnknown: interfaces are asked for, references counted, and at zero the object is gone."""

from __future__ import annotations

import uuid
from typing import ClassVar

import pytest

import canwire
from canwire import vci
from canwire.vci.unknown import Unknown, vci_call
from tests.cases import each

pytestmark = pytest.mark.conforms("X4-04")


class Thing(Unknown):
    interfaces: ClassVar[frozenset[uuid.UUID]] = frozenset({vci.IID_IUnknown, vci.IID_IVciDevice})

    def __init__(self) -> None:
        super().__init__()
        self.closed = 0

    @vci_call
    def work(self, hard: bool = False) -> str:
        """Do something."""
        if hard:
            raise canwire.WrongState("too hard now")
        return "done"

    def _close(self) -> None:
        self.closed += 1


def test_a_known_interface_is_another_reference() -> None:
    thing = Thing()
    assert thing.query_interface(vci.IID_IVciDevice) is thing
    assert thing.query_interface(vci.IID_IUnknown) is thing
    assert [thing.release(), thing.release(), thing.release()] == [2, 1, 0]


def test_an_unknown_interface_is_refused_by_name() -> None:
    thing = Thing()
    with pytest.raises(vci.VciNoInterface, match="Thing has no ICanSocket"):
        thing.query_interface(vci.IID_ICanSocket)
    with pytest.raises(vci.VciNoInterface, match="00000000-0000-0000-0000-000000000007"):
        thing.query_interface(uuid.UUID(int=7))
    assert thing.release() == 0


def test_references_are_counted() -> None:
    thing = Thing()
    assert [thing.add_ref(), thing.add_ref()] == [2, 3]
    assert [thing.release(), thing.release()] == [2, 1]
    assert thing.closed == 0
    assert thing.release() == 0
    assert thing.closed == 1


@each("use", ["work", "add_ref", "release"])
def test_at_zero_it_is_gone(use: str) -> None:
    thing = Thing()
    thing.release()
    with pytest.raises(vci.VciError, match="this Thing was released") as raised:
        getattr(thing, use)()
    assert raised.value.code == vci.VCI_E_INVHANDLE
    with pytest.raises(vci.VciError) as raised:
        thing.query_interface(vci.IID_IUnknown)
    assert raised.value.code == vci.VCI_E_INVHANDLE
    assert thing.closed == 1


def test_a_with_block_gives_its_reference_back() -> None:
    with Thing() as thing:
        assert thing.work() == "done"
    assert thing.closed == 1
    with Thing() as thing:
        thing.add_ref()
    assert thing.closed == 0
    with Thing() as thing:
        thing.release()
    assert thing.closed == 1


def test_calls_translate_errors() -> None:
    thing = Thing()
    with pytest.raises(vci.VciInvalidState, match="too hard now"):
        thing.work(hard=True)
    assert Thing.work.__doc__ == "Do something."


def test_a_board_pulled_out_before_is_released_all_the_same() -> None:
    class Gone(Thing):
        def _close(self) -> None:
            raise canwire.Unplugged("pulled out")

    assert Gone().release() == 0
