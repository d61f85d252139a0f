"""The send window on a bus: what was actually sent, when, and what an abort leaves."""

from __future__ import annotations

from pathlib import Path

import pytest

from canwire import Frame
from canwire.candrv import CanMode, RegistryStore
from canwire.web.cancheck.listing import PAUSED
from canwire.web.cancheck.recipe import Range, Recipe
from tests.candrv.bench import Bench
from tests.web.cancheck.conftest import Program
from tests.web.cancheck.test_generators import example


def recipe(identifier: int, data: bytes = b"", *, delay_ms: int = 10, extended: bool = False) -> Recipe:
    ranges = tuple(Range(value, value) for value in data)
    return Recipe(Range(identifier, identifier), ranges, delay_ms=delay_ms, extended=extended)


@pytest.mark.conforms("FT-12")
@pytest.mark.parametrize("paired", [False, True], ids=["send", "send and receive"])
def test_every_message_sent_is_listed_with_its_generator(
    program: Program, bench: Bench, paired: bool
) -> None:
    window = program.pair()[0] if paired else program.send()
    window.generators.add(recipe(0x123, b"\x0a\xff", delay_ms=10), active=True)
    window.generators.add(recipe(0x7FF, delay_ms=20), active=True)
    program.run(0.025)
    assert [row[1:] for row in window.list.rows()] == [
        ("0", "STD", "00000123", "0", "2", "0A FF"),
        ("1", "STD", "000007FF", "0", "0", ""),
        ("0", "STD", "00000123", "0", "2", "0A FF"),
        ("1", "STD", "000007FF", "0", "0", ""),
        ("0", "STD", "00000123", "0", "2", "0A FF"),
    ]
    assert [frame.id for frame in bench.peer.received(5)] == [0x123, 0x7FF, 0x123, 0x7FF, 0x123]
    times = [int(row[0], 16) for row in window.list.rows()]
    assert (times[2] - times[0], times[4] - times[0]) == (10, 20)


@pytest.mark.conforms("FT-12")
def test_a_message_that_nobody_acknowledges_is_not_listed(bench: Bench) -> None:
    bench.absent_peer()
    program = Program(bench)
    bench.peer.stop()
    window = program.send()
    window.generators.add(recipe(0x123, delay_ms=10_000), active=True)
    program.run(0.1)
    assert window.list.rows() == []
    bench.peer.start()
    program.run(0.1)
    assert len(window.list.rows()) == 1
    program.leave()


@pytest.mark.conforms("FT-12")
def test_abort_empties_the_send_buffer(bench: Bench) -> None:
    bench.absent_peer()
    program = Program(bench)
    bench.peer.stop()
    window = program.send()
    window.generators.add(recipe(0x123, delay_ms=1), active=True)
    program.run(0.01)
    window.generators.pause_all()
    assert window.handle.sending.waiting > 1
    assert window.abort() >= 10
    bench.peer.start()
    window.generators.add(recipe(0x200, delay_ms=10_000), active=True)
    program.run(0.1)
    assert [row[3] for row in window.list.rows() if row[1] == "1"] == ["00000200"]
    assert len(window.list.rows()) <= 2
    assert window.given_up + len(window.list.rows()) == 12
    program.leave()


@pytest.mark.conforms("FT-13")
def test_a_full_send_buffer_lets_the_generator_wait(bench: Bench, registry: RegistryStore) -> None:
    registry.set("CID1", "SendBufferSize", 5)
    bench.absent_peer()
    program = Program(bench)
    bench.peer.stop()
    window = program.send()
    window.generators.add(example_standard(), active=True)
    program.run(0.2)
    (row,) = window.generators.rows()
    assert row.waits
    bench.peer.start()
    program.run(1.0)
    sent = [int(row[6][:2], 16) for row in window.list.rows()]
    assert sent == list(range(0x34))  # none skipped
    program.leave()


def example_standard() -> Recipe:
    return Recipe(Range(0x100, 0x100), (Range(0, 0x33),), delay_ms=1, use_range=True)


@pytest.mark.conforms("FT-16")
@pytest.mark.conforms("FT-18")
def test_the_examples_on_the_bus(program: Program, bench: Bench) -> None:
    program.port.set_mode(CanMode.CAN_2_0_B)
    window = program.send()
    window.generators.add(example(), active=True)
    program.run(2 * 59.5)
    window.generators.pause(0)
    window.generators.add(example(repeat=False), active=True)
    program.run(2 * 60)
    frames = bench.peer.received(60 + 52)
    assert bench.peer.receive(0) is None
    assert {(frame.id, frame.extended) for frame in frames} == {(0x025E0235, True)}
    data = [frame.data.hex(" ").upper() for frame in frames]
    assert [data[number - 1] for number in (18, 19, 52, 53)] == [
        "11 22 22",
        "00 11 21",
        "0F 20 00",
        "10 21 33",
    ]
    assert data[60:] == data[:52]
    assert [window.generator_row(row)[0] for row in window.generators.rows()] == [PAUSED, PAUSED]
    rows = window.list.rows()
    assert len(rows) == 112
    assert rows[17][1:] == ("0", "EXT", "025E0235", "0", "3", "11 22 22")
    assert int(rows[1][0], 16) - int(rows[0][0], 16) == 2000


@pytest.mark.conforms("FT-13")
def test_generator_rows_show_the_time_and_the_next_message(program: Program) -> None:
    window = program.send()
    window.generators.add(recipe(0x123, b"\x01", delay_ms=1000), active=True)
    window.generators.add(recipe(0x124), active=False)
    program.run(0.5)
    first, second = map(window.generator_row, window.generators.rows())
    assert first[1:] == ("0", "STD", "00000123", "0", "1", "01")
    assert 0 < int(first[0], 16) - window.handle.time() <= 1000
    assert second[:4] == (PAUSED, "1", "STD", "00000124")


@pytest.mark.conforms("FT-14")
def test_extended_frames_in_2_0_a_are_told_and_not_sent(program: Program) -> None:
    window = program.send()
    window.generators.add(recipe(0x12345678, extended=True), active=True)
    program.run(0.1)
    (row,) = window.generators.rows()
    assert row.due_ns is None
    assert "standard identifier" in row.trouble
    assert window.list.rows() == []


@pytest.mark.conforms("FT-12")
def test_other_programs_messages_are_not_listed(program: Program, bench: Bench) -> None:
    window = program.send()
    with bench.open(read=False, hub=bench.program("another")) as other:
        other.write_message(0x321, b"\x01")
        program.run(0.01)
        assert bench.peer.receive() == Frame(0x321, b"\x01")
    assert window.list.rows() == []


@pytest.mark.conforms("FT-12")
def test_the_log_has_the_messages_from_then_on(program: Program, tmp_path: Path) -> None:
    window = program.send()
    window.generators.add(recipe(0x123, b"\x01\x02", delay_ms=10), active=True)
    program.run(0.015)
    window.list.open_log(tmp_path / "sent.txt")
    program.run(0.010)
    window.list.close_log()
    (line,) = (tmp_path / "sent.txt").read_text().splitlines()
    assert line.split("\t")[1:] == ["0", "STD", "00000123", "0", "2", "01 02"]


@pytest.mark.conforms("FT-12")
def test_in_single_message_mode_messages_go_one_by_one(bench: Bench, registry: RegistryStore) -> None:
    registry.set("CID1", "TxMode", 0)
    program = Program(bench)
    window = program.send()
    window.generators.add(recipe(0x123, delay_ms=10), active=True)
    program.run(0.035)
    assert len(window.list.rows()) == 4
    program.leave()
