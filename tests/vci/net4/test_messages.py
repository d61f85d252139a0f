"""Messages of Ixxat.Vci4, their factory, and what readers and writers do with both kinds."""

from __future__ import annotations

from typing import Any

import pytest

from canwire import vci
from canwire.vci import net4
from canwire.vci.net4 import CanBitrate2, CanFdBitrate, ICanMessage, ICanMessage2, ILinMessage
from tests.vci.net4.programs import CLASSIC_BOARD, LONG_MS, Net4

ROOM = {ICanMessage: 8, ICanMessage2: 64}
kinds = pytest.mark.parametrize("kind", list(ROOM))


def test_the_factory_makes_the_three_kinds() -> None:
    factory = net4.VciServer.instance().msg_factory
    for kind in (ICanMessage, ICanMessage2, ILinMessage):
        made: Any = factory.create_msg(kind)
        assert type(made) is kind
        assert made.data_length == made.time_stamp == 0
    with pytest.raises(net4.ArgumentException, match="ICanMessage2"):
        factory.create_msg(net4.CanBitrate2)  # type: ignore[type-var]


def test_there_is_one_server_beside_v3s() -> None:
    server = net4.VciServer.instance()
    assert server is net4.VciServer.instance()
    assert server is not vci.v3.VciServer.instance()
    assert server.version.major == vci.get_version().vci_major_version


@kinds
def test_bytes_and_length_have_their_room(kind: Any) -> None:
    message, room = kind(), ROOM[kind]
    message.data_length = room
    message[room - 1] = 0xFF
    assert (message.data_length, message[room - 1], message[0]) == (room, 0xFF, 0)
    for wrong in (room, -1):
        with pytest.raises(net4.ArgumentOutOfRangeException):
            message[wrong]
    for wrong in (room + 1, -1):
        with pytest.raises(net4.ArgumentOutOfRangeException):
            message.data_length = wrong
    message.clear()
    assert (message.data_length, message[room - 1]) == (0, 0)


def test_lengths_between_those_of_can_fd_become_the_next_one() -> None:
    message = ICanMessage2()
    found = []
    for length in (8, 9, 12, 13, 33, 48, 49):
        message.data_length = length
        found.append(message.data_length)
    assert found == [8, 12, 12, 16, 48, 48, 64]


@kinds
def test_flags_are_bits_of_the_message(kind: Any) -> None:
    for name, bit in (
        ("extended_data_length", "edl"),
        ("fast_data_rate", "fdr"),
        ("error_state_indicator", "esi"),
        ("single_shot_mode", "ssm"),
        ("high_priority_msg", "hpm"),
    ):
        message = kind()
        setattr(message, name, True)
        assert getattr(message, name) is True
        assert message.raw.msg_info == vci.CanMsgInfo(**{bit: 1})  # type: ignore[misc]


def test_each_channel_gives_its_own_kind_and_takes_both(net4: Net4) -> None:
    net4.start(0)
    net4.start(1)
    long, classic = net4.port(0), net4.port(1, classic=True)
    assert classic.writer.send_message(net4.message(ICanMessage2, 1, b"12345678"))
    assert long.writer.send_message(net4.message(ICanMessage, 2, b"abc"))
    [first], [second] = long.receive(), classic.receive()
    assert (type(first), first.identifier, bytes(first[k] for k in range(8))) == (
        ICanMessage2,
        1,
        b"12345678",
    )
    assert (type(second), second.identifier, second.data_length) == (ICanMessage, 2, 3)
    out = ICanMessage2()
    assert classic.writer.send_messages([net4.message(ICanMessage, 3)] * 2) == 2
    [third] = long.receive()
    while not long.reader.fill_count:
        assert long.event.wait_one(LONG_MS)
    assert long.reader.read_message(out=out)
    assert (third.identifier, out.identifier) == (3, 3)


def test_what_a_channel_cannot_take_is_refused(net4: Net4) -> None:
    classic = net4.port(1, classic=True)
    fd = net4.message(ICanMessage2, 1, bytes(12), extended_data_length=True)
    with pytest.raises(vci.net4.ArgumentException, match="ICanChannel2"):
        classic.writer.send_message(fd)
    with pytest.raises(vci.net4.ArgumentException, match="ICanMessage belongs here"):
        classic.writer.send_message(vci.CanMsg())
    net4.start(0, started=False)
    port = net4.port(0)
    net4.start(1)
    partner = net4.port(1)
    with pytest.raises(vci.net4.VciException, match="CAN_FEATURE_EXTDATA"):
        net4.port(0, CLASSIC_BOARD).writer.send_message(fd)
    assert partner.writer.send_message(net4.message(ICanMessage, 1))
    net4.open(vci.net4.ICanSocket)
    assert port.reader.fill_count == 0


def test_a_message_of_the_wrong_kind_is_not_read_into(virtual4: Net4) -> None:
    control = virtual4.start(0)
    port = virtual4.port(0)
    control.stop_line()
    with pytest.raises(net4.ArgumentException, match="reads CanMessage2"):
        port.reader.read_message(out=ICanMessage())
    port.reader.read_messages()
    assert port.reader.read_messages() == []
    assert not port.reader.read_message(out=ICanMessage2())


def test_rates_are_v4s_structures_and_come_back_with_their_names() -> None:
    every = [one for one in vars(CanBitrate2).values() if isinstance(one, CanBitrate2)]
    assert len(every) == 38
    for one in every:
        assert CanBitrate2.of(one.structure()) == one
    fast = CanBitrate2.CANFD_2000_KBIT
    assert fast.structure() == vci.CAN_BTP_DBR_SL_2000KB
    assert str(CanBitrate2.of(vci.CAN_BTP_DBR_SL_2000KB)) == str(fast) == "CAN FD 2000 kbit/s"
    assert str(CanBitrate2(net4.CanBitrateMode.RAW, 1, 2, 3, 4, 5)) == "not specified"
    assert CanBitrate2.IFI_4000_KBIT.mode == net4.CanBitrateMode.RAW
    with pytest.raises(net4.ArgumentOutOfRangeException):
        CanBitrate2(net4.CanBitrateMode.NONE, 1, 0x10000, 3, 4, 5)


def test_pairs_of_rates() -> None:
    both = CanFdBitrate(CanBitrate2.CIA_500_KBIT)
    assert both.std_bitrate is both.fast_bitrate
    assert both == CanFdBitrate(CanBitrate2.CIA_500_KBIT, CanBitrate2.CIA_500_KBIT)
    tables = (
        CanFdBitrate.CIA_BIT_RATES,
        CanFdBitrate.SHORT_LINE_CANFD_BIT_RATES,
        CanFdBitrate.LONG_LINE_CANFD_BIT_RATES,
        CanFdBitrate.CANOPEN_BIT_RATES,
    )
    assert [len(table) for table in tables] == [8, 7, 6, 20]


def test_every_rate_that_has_a_name_may_resynchronise_by_no_more_than_its_second_segment() -> None:
    rates = [rate for rate in vars(CanBitrate2).values() if isinstance(rate, CanBitrate2)]
    assert len(rates) > 30
    for rate in rates:
        assert rate.sjw <= rate.time_segment2, rate.name
