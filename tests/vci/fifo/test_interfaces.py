"""From one interface of a FIFO to the others."""

from __future__ import annotations

from typing import Any

import pytest

from canwire import vci
from tests.vci.programs import Program

FIFO, FIFO2, READER, WRITER = vci.IID_IVciFifo, vci.IID_IVciFifo2, vci.IID_IFifoReader, vci.IID_IFifoWriter
pytestmark = pytest.mark.finding("vci F6")


@pytest.mark.parametrize("first", [FIFO, FIFO2, READER, WRITER])
@pytest.mark.usefixtures("hub")
def test_a_fifo_of_ones_own_has_all_of_them(first: Any) -> None:
    _, made = vci.create_fifo(10, 4, first)
    with made:
        for iid, kind in ((FIFO2, vci.VciFifo2), (READER, vci.FifoReader), (WRITER, vci.FifoWriter)):
            with made.query_interface(iid) as other:
                assert isinstance(other, kind)
                assert other.get_entry_size() == 4
                assert (other is made) == (iid == first or (first, iid) == (FIFO, FIFO2))
        with pytest.raises(vci.VciNoInterface):
            made.query_interface(vci.IID_ICanSocket)


@pytest.mark.usefixtures("hub")
def test_an_end_is_given_out_once() -> None:
    _, whole = vci.create_fifo(10, 4)
    with whole, whole.query_interface(READER) as reader:
        with pytest.raises(vci.VciAccessDenied):
            whole.query_interface(READER)
        with pytest.raises(vci.VciAccessDenied):
            whole.reset()
        with reader.query_interface(WRITER) as writer:
            writer.put_data_entry(b"abcd")
        assert reader.get_data_entry() == b"abcd"


def test_a_channels_fifos_can_be_looked_at(program: Program) -> None:
    channel = program.keep(program.open(vci.IID_ICanSocket).create_channel(False))
    channel.initialize(100, 100)
    reader, writer = channel.get_reader(), channel.get_writer()
    capacity = writer.get_capacity()
    writer.put_data_entry(vci.CanMsg(msg_id=1))
    with writer.query_interface(FIFO2) as whole:
        assert (whole.get_capacity(), whole.get_entry_size()) == (capacity, 20)
        assert (whole.get_fill_count(), whole.get_free_count()) == (1, capacity - 1)
        assert whole.get_fill_level() == 100 // capacity
        with pytest.raises(vci.VciAccessDenied, match="end"):
            whole.reset()
        for iid in (READER, WRITER):
            with pytest.raises(vci.VciAccessDenied):
                whole.query_interface(iid)
    whole = reader.query_interface(FIFO)
    reader.release()
    reader = whole.query_interface(READER)
    assert isinstance(reader, vci.FifoReader)
    channel.initialize(100, 100)
    with pytest.raises(vci.VciError, match="initialised again") as raised:
        whole.get_fill_level()
    assert raised.value.code == vci.VCI_E_INVHANDLE
    for one in (whole, reader, writer):
        one.release()


def test_a_monitors_fifo_can_be_looked_at(program: Program) -> None:
    port = program.monitor()
    with port.reader.query_interface(FIFO2) as whole:
        assert (whole.get_entry_size(), whole.get_fill_level()) == (16, 0)
        with pytest.raises(vci.VciAccessDenied):
            whole.query_interface(WRITER)
