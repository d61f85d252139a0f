"""ICanChannel: its life, and who may have one."""

from __future__ import annotations

import pytest

from canwire import vci
from canwire.vci import v3
from tests.vci.v3.programs import NetProgram


@pytest.mark.conforms("X3-16")
def test_before_it_is_initialised_a_channel_can_do_nothing(net: NetProgram) -> None:
    channel = net.open(v3.CanChannel)
    for use in (
        channel.activate,
        channel.deactivate,
        channel.get_message_reader,
        channel.get_message_writer,
        lambda: channel.channel_status,
    ):
        with pytest.raises(v3.ObjectDisposedException) as raised:
            use()
        assert raised.value.code == vci.VCI_E_NOT_INITIALIZED
    assert channel.line_status.is_in_init_mode


@pytest.mark.conforms("X3-16")
def test_a_channel_is_inactive_until_it_is_activated(net: NetProgram) -> None:
    channel = net.open(v3.CanChannel)
    channel.initialize(10, 10, False)
    assert not channel.channel_status.is_activated
    channel.activate()
    assert channel.channel_status.is_activated
    channel.deactivate()
    assert not channel.channel_status.is_activated
    channel.activate()
    channel.initialize(10, 10, False)
    assert not channel.channel_status.is_activated


@pytest.mark.parametrize("sizes", [(0, 10), (-1, 10), (65_536, 10), (10, -1), (10, 65_536)])
def test_sizes_that_are_none(net: NetProgram, sizes: tuple[int, int]) -> None:
    channel = net.open(v3.CanChannel)
    with pytest.raises(v3.ArgumentException):
        channel.initialize(*sizes, False)
    with pytest.raises(v3.ObjectDisposedException):
        channel.activate()


def test_a_channel_without_transmit_fifo_has_no_writer(net: NetProgram) -> None:
    channel = net.open(v3.CanChannel)
    channel.initialize(10, 0, False)
    with pytest.raises(v3.VciException):
        channel.get_message_writer()


@pytest.mark.finding("vendor 5")
@pytest.mark.conforms("X3-17")
def test_an_exclusive_channel_is_alone(net: NetProgram, other_net: NetProgram) -> None:
    channel = net.open(v3.CanChannel)
    channel.initialize(10, 10, True)
    for program in (net, other_net):
        with pytest.raises(v3.VciException) as raised:
            program.open(v3.CanChannel)
        assert raised.value.code == vci.VCI_E_ACCESSDENIED
    channel.dispose()
    other_net.open(v3.CanChannel).initialize(10, 10, False)


@pytest.mark.conforms("X3-17")
def test_a_channel_beside_others_cannot_become_exclusive(net: NetProgram, other_net: NetProgram) -> None:
    channel, other = net.open(v3.CanChannel), other_net.open(v3.CanChannel)
    with pytest.raises(v3.VciException) as raised:
        channel.initialize(10, 10, True)
    assert raised.value.code == vci.VCI_E_ACCESSDENIED
    for one in (channel, other):
        one.initialize(10, 10, False)
        one.activate()
    other.dispose()
    channel.initialize(10, 10, True)
    with pytest.raises(v3.VciException):
        other_net.open(v3.CanChannel)
    channel.initialize(10, 10, False)
    other_net.open(v3.CanChannel)


@pytest.mark.conforms("X3-08", "X3-17")
@pytest.mark.parametrize("held", [True, False])
def test_becoming_exclusive_leaves_the_line_as_it_is(net: NetProgram, held: bool) -> None:
    channel = net.open(v3.CanChannel)
    control = net.start()
    if not held:
        control.dispose()
    channel.initialize(10, 10, True)
    assert not channel.line_status.is_in_init_mode
    if not held:
        net.open(v3.CanControl)


def test_initialising_anew_ends_reader_and_writer(net: NetProgram) -> None:
    port = net.port()
    port.channel.initialize(10, 10, False)
    for use in (port.reader.read_message, lambda: port.writer.send_message(v3.CanMessage())):
        with pytest.raises(v3.ObjectDisposedException):
            use()
    port.channel.get_message_reader().dispose()


@pytest.mark.conforms("X3-21")
@pytest.mark.parametrize("name", ["get_message_reader", "get_message_writer"])
def test_reader_and_writer_open_once_each(net: NetProgram, name: str) -> None:
    channel = net.open(v3.CanChannel)
    channel.initialize(10, 10, False)
    get = getattr(channel, name)
    with get():
        with pytest.raises(v3.VciException) as raised:
            get()
        assert raised.value.code == vci.VCI_E_ACCESSDENIED
    get().dispose()


@pytest.mark.finding("vendor 8")
def test_a_disposed_end_counts_nothing_and_does_nothing(net: NetProgram) -> None:
    port = net.port()
    port.reader.dispose()
    port.writer.dispose()
    assert (port.reader.capacity, port.reader.fill_count) == (0, 0)
    assert (port.writer.capacity, port.writer.free_count) == (0, 0)
    assert (port.reader.threshold, port.writer.threshold) == (0, 0)
    for use in (
        port.reader.read_message,
        port.reader.lock,
        lambda: port.reader.read_messages(1),
        lambda: setattr(port.reader, "threshold", 5),
        lambda: port.writer.send_message(v3.CanMessage()),
        lambda: port.writer.assign_event(None),
    ):
        with pytest.raises(v3.ObjectDisposedException):
            use()
