"""Messages of several frames between two computers, in a time of their own (SAE J1939-21 5.10, ISO 11783-3 5.11)."""

from __future__ import annotations

import errno

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.socketcan.j1939.codes import Abort, error_of
from canwire.socketcan.j1939.reports import What
from tests.cases import each
from tests.effort import examples
from tests.socketcan.j1939.scene import Scene, Socket

PGN = 0x12300


def pair(scene: Scene, largest: int = 1 << 20) -> tuple[Socket, Socket]:
    return Socket(scene.node(), 0x20), Socket(scene.node(largest), 0x30)


@pytest.mark.conforms("N-49")
@examples(40)
@given(st.one_of(st.integers(0, 1785), st.integers(1786, 6000)), st.booleans())
def test_messages_arrive_whole(size: int, local: bool) -> None:
    """Between two computers, and between two sockets of one."""
    scene = Scene()
    sender, receiver = pair(scene)
    if local:
        receiver = Socket(sender.node, 0x40)
    data = bytes((k * 7 + 3) & 0xFF for k in range(size))
    sender.send(PGN, data, receiver.endpoint.address)
    scene.run_for(20)
    assert receiver.data == [data]
    assert sender.over == [0]
    heard = receiver.heard[0]
    assert (heard.pgn, heard.source, heard.destination) == (PGN, 0x20, receiver.endpoint.address)
    assert sender.outbox.pending == 0


@pytest.mark.conforms("N-49")
def test_the_frames_of_a_message() -> None:
    scene = Scene()
    sender, _ = pair(scene)
    sender.send(PGN, bytes(range(1, 17)), 0x30)
    scene.run_for(1)
    assert scene.lines == [
        "18EC3020 1010000303002301",
        "18EC2030 110301ffff002301",
        "18EB3020 0101020304050607",
        "18EB3020 0208090a0b0c0d0e",
        "18EB3020 030f10ffffffffff",
        "18EC2030 13100003ff002301",
    ]


def test_the_frames_of_a_long_message() -> None:
    """Its blocks have up to 255 frames, and each begins with the number of the frame before it."""
    scene = Scene()
    sender, _ = pair(scene)
    sender.send(PGN, bytes(1786), 0x30)
    scene.run_for(5)
    control = [line for line in scene.lines if line.startswith("18C8")]
    assert control == [
        "18C83020 14fa060000002301",
        "18C82030 15ff010000002301",
        "18C83020 16ff000000002301",
        "18C82030 1501000100002301",
        "18C83020 1601ff0000002301",
        "18C82030 17fa060000002301",
    ]


@pytest.mark.conforms("N-49")
def test_a_message_to_all_takes_its_time() -> None:
    scene = Scene()
    sender, receiver = pair(scene)
    sender.send(0xFEEC, bytes(range(20)))
    scene.run_for(1)
    assert receiver.data == [bytes(range(20))]
    assert sender.over == [0]
    assert scene.lines[0] == "18ECFF20 20140003ffecfe00"
    assert scene.times_ms == [0.2, 50.2, 100.2, 150.2]


def test_a_message_to_all_that_ends_too_early_is_nobody_s() -> None:
    scene = Scene()
    _, receiver = pair(scene)
    scene.inject("18ECFF55 20140003ffecfe00")
    scene.inject("18EBFF55 0100010203040506")
    scene.run_for(0.7)
    assert [report.what for report in receiver.reports] == [What.ANNOUNCED]
    scene.run_for(0.1)
    assert [(report.what, report.error) for report in receiver.reports[1:]] == [
        (What.LOST, errno.EHOSTUNREACH)
    ]
    assert len(scene.lines) == 2  # nobody is asked to stop


@pytest.mark.conforms("N-49")
def test_nobody_answers() -> None:
    scene = Scene()
    sender, _ = pair(scene)
    sender.send(PGN, bytes(20), 0x55)
    scene.run_for(1.2)
    assert sender.over == []
    scene.run_for(0.1)
    assert sender.over == [errno.EHOSTUNREACH]
    assert scene.lines[1] == "18EC5520 ff03ffffff002301"


def test_who_does_not_want_it_does_not_answer() -> None:
    scene = Scene()
    sender, receiver = pair(scene)
    receiver.endpoint.pgn_heard = 0x1200
    sender.send(PGN, bytes(20), 0x30)
    scene.run_for(2)
    assert sender.over == [errno.EHOSTUNREACH]


@each("reason", [*Abort, 99])
def test_what_an_abort_means(reason: int) -> None:
    scene = Scene()
    sender, _ = pair(scene)
    sender.send(PGN, bytes(20), 0x55)
    scene.inject(f"18EC2055 ff{reason:02x}ffffff002301")
    assert sender.over == [error_of(reason)]


def test_an_abort_of_another_message_is_none_of_this_one() -> None:
    scene = Scene()
    sender, _ = pair(scene)
    sender.send(PGN, bytes(20), 0x55)
    scene.inject("18EC2055 ff01ffffff002401")
    assert sender.over == []


def test_a_receiver_asks_for_patience_and_for_a_part_again() -> None:
    scene = Scene()
    sender, _ = pair(scene)
    sender.send(PGN, bytes(range(20)), 0x55)
    scene.inject("18EC2055 1100ffffff002301")
    scene.run_for(0.5)
    scene.inject("18EC2055 110201ffff002301")
    scene.run_for(0.1)
    scene.inject("18EC2055 110202ffff002301")
    scene.run_for(0.1)
    data = [line.split()[1] for line in scene.lines if line.startswith("18EB")]
    assert [line[:2] for line in data] == ["01", "02", "02", "03"]
    assert [report.done for report in sender.reports if report.what is What.SCHEDULED] == [7]
    scene.inject("18EC2055 13140003ff002301")
    assert sender.over == [0]


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("18EC2055 110400ffff002301", Abort.FAULT),  # there is no packet 0
        ("18EC2055 110901ffff002301", Abort.FAULT),  # more than there are
    ],
)
def test_answers_that_make_no_sense(line: str, reason: Abort) -> None:
    scene = Scene()
    sender, _ = pair(scene)
    sender.send(PGN, bytes(20), 0x55)
    scene.inject(line)
    scene.run_for(0.01)
    assert sender.over == [error_of(reason)]
    assert scene.lines[-1] == f"18EC5520 ff{reason:02x}ffffff002301"


def test_an_answer_about_another_message_is_refused() -> None:
    scene = Scene()
    sender, _ = pair(scene)
    sender.send(PGN, bytes(20), 0x55)
    scene.inject("18EC2055 110301ffff002401")
    scene.run_for(0.01)
    assert scene.lines[-1] == "18EC5520 ff0effffff002401"
    assert sender.over == []


@each(
    ("line", "reason"),
    [
        ("18EC3055 1007000101002301", Abort.FAULT),  # it would be a single frame
        ("18C83055 1410000000002301", Abort.FAULT),  # too short for the extended protocol
        ("18C83055 1401000100002301", Abort.RESOURCE),  # longer than a program can be given
    ],
)
def test_what_is_refused(line: str, reason: Abort) -> None:
    scene = Scene()
    _, receiver = pair(scene, largest=60_000)
    scene.inject(line)
    scene.run_for(0.01)
    assert scene.lines[-1].split()[1] == f"ff{reason:02x}ffffff002301"
    assert receiver.reports == []


def test_a_second_message_of_the_same_sender_s_at_a_time() -> None:
    scene = Scene()
    _, receiver = pair(scene)
    scene.inject("18EC3055 1014000303002301")
    scene.inject("18EC3055 1014000303002401")
    scene.run_for(0.01)
    assert scene.lines[-1] == "18EC5530 ff01ffffff002401"
    scene.inject("18EC3055 1014000303002301")
    scene.run_for(0.01)
    assert scene.lines[-1] == "18EC5530 ff01ffffff002301"
    assert receiver.reports[-1].error == errno.EALREADY


def test_a_sender_that_goes_silent() -> None:
    scene = Scene()
    _, receiver = pair(scene)
    scene.inject("18EC3055 1014000303002301")
    scene.inject("18EB3055 0100010203040506")
    scene.run_for(0.7)
    assert len(scene.lines) == 3
    scene.run_for(0.1)
    assert scene.lines[-1] == "18EC5530 ff03ffffff002301"
    assert (receiver.data, receiver.reports[-1].done) == ([], 7)


@pytest.mark.conforms("N-49")
def test_one_message_after_the_other() -> None:
    """Of one socket in their order; one that fails lets the next begin."""
    scene = Scene()
    sender, receiver = pair(scene)
    sender.send(PGN, bytes(20), 0x55)
    sender.send(PGN, b"short", 0x30)
    sender.send(PGN, bytes(30), 0x30)
    assert sender.outbox.pending == 3
    scene.run_for(1.2)
    assert receiver.data == []
    scene.run_for(1)
    assert receiver.data == [b"short", bytes(30)]
    assert sender.over == [errno.EHOSTUNREACH, 0, 0]


def test_two_sockets_with_one_address_at_a_time() -> None:
    scene = Scene()
    sender, _ = pair(scene)
    other = Socket(sender.node, 0x20)
    sender.send(PGN, bytes(20), 0x30)
    with pytest.raises(OSError, match="busy"):
        other.send(PGN, bytes(20), 0x30)


@pytest.mark.conforms("N-49")
def test_what_the_error_queue_has() -> None:
    scene = Scene()
    sender, receiver = pair(scene)
    sender.send(PGN, bytes(5), 0x30)
    sender.send(PGN, bytes(20), 0x30)
    scene.run_for(1)
    told = [(report.what, report.number, report.done) for report in sender.reports]
    assert told == [(What.SCHEDULED, 0, 5), (What.ACKNOWLEDGED, 0, 5), (What.ACKNOWLEDGED, 1, 20)]
    assert [(report.what, report.size) for report in receiver.reports] == [(What.ANNOUNCED, 20)]
    statistics = receiver.reports[0].statistics()
    assert statistics.hex() == (
        "0800020014000000"  # total size
        "0800030000230100"  # PGN
        "0c0004000000000000000000"
        "0c0005000000000000000000"
        "0500060020000000"
        "0500070030000000"
    )
    assert sender.reports[1].statistics().hex() == "0800010005000000"
    assert sender.reports[2].extended_error(1 << 7).hex() == "2a000000040000000200000001000000"


def test_a_single_frame_that_never_gets_out() -> None:
    scene = Scene()
    sender, _ = pair(scene)
    scene.lose = {PGN}
    sender.send(PGN, b"1", 0x30)
    scene.run_for(9.9)
    assert sender.outbox.pending == 1
    scene.run_for(0.2)
    assert sender.outbox.pending == 0
    assert (sender.reports[-1].what, sender.reports[-1].error) == (What.ABORTED, errno.ETIME)


@pytest.mark.conforms("N-49")
def test_the_bus_goes() -> None:
    scene = Scene()
    sender, receiver = pair(scene)
    sender.send(PGN, bytes(2000), 0x30)
    scene.run_for(0.001)
    sender.outbox.stop(errno.ENETDOWN)
    receiver.node.network.stop(errno.ENETDOWN)
    assert sender.over == [errno.ENETDOWN]
    assert receiver.reports[-1].error == errno.ENETDOWN
    scene.run_for(5)
    assert receiver.data == []


@given(st.integers(0, 0x1FFFFFFF), st.binary(max_size=8))
def test_rubbish_delivers_nothing_wrong(identifier: int, data: bytes) -> None:
    scene = Scene()
    sender, receiver = pair(scene)
    sender.send(PGN, bytes(20), 0x30)
    scene.run_for(0.0005)
    scene.inject(f"{identifier:08X} {data.hex() or '00'}")
    scene.run_for(5)
    assert all(len(message) in (20, len(data) or 1) for message in receiver.data)
