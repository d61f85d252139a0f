"""The receive window: its list of events, log, event mask and acceptance filter."""

from __future__ import annotations

from pathlib import Path

import pytest

from canwire import BadValue, Frame
from canwire.candrv import Event, Filter, RegistryStore
from canwire.web.cancheck.listing import KEPT, Listing, event_row
from canwire.web.cancheck.receive import KINDS
from tests.candrv.bench import Bench
from tests.web.cancheck.conftest import Program

FULL = Path("/dev/full")

# the list


@pytest.mark.conforms("FT-08")
@pytest.mark.parametrize(
    ("event", "row"),
    [
        (
            Event(0x001, 0x12568, 0, 1, 0x112, 0, 2, b"\x0a\xff"),
            ("RECEIVED", "00012568", "0", "STD", "00000112", "0", "2", "0A FF"),
        ),
        (
            Event(0x002, 0x1_0000_000A, 0x1F, 2, 0x1ABCDEF0, 0, 8, bytes(range(8))),
            ("TRANSMITTED", "0000000A", "1F", "EXT", "1ABCDEF0", "0", "8", "00 01 02 03 04 05 06 07"),
        ),
        (
            Event(0x400, 1, 0, 1, 0x112, 1, 15, b""),
            ("ABORTED", "00000001", "0", "STD", "00000112", "1", "F", ""),
        ),
        (
            Event(0x001, 1, 0, 1, 0x112, 0, 12, bytes(8)),
            ("RECEIVED", "00000001", "0", "STD", "00000112", "0", "C", "00 00 00 00 00 00 00 00"),
        ),
        (Event(0x040, 255, 3, 1, 5, 0, 1, b"\1"), ("OVERRUN", "000000FF", "3", "", "", "", "", "")),
    ],
)
def test_all_columns_are_hexadecimal_and_only_messages_have_all_of_them(
    event: Event, row: tuple[str, ...]
) -> None:
    assert event_row(event) == row


@pytest.mark.conforms("FT-08")
def test_events_of_the_bus_are_listed(program: Program, bench: Bench) -> None:
    window = program.receive()
    bench.peer.send(Frame(0x123, b"\x11\x22"), Frame(0x7FF, remote=True, dlc=4))
    program.run(0.01)
    rows = window.list.rows()
    assert [row[:1] + row[2:] for row in rows] == [
        ("RECEIVED", "0", "STD", "00000123", "0", "2", "11 22"),
        ("RECEIVED", "0", "STD", "000007FF", "1", "4", ""),
    ]
    assert int(rows[1][1], 16) <= window.handle.time()


@pytest.mark.conforms("FT-08")
def test_the_column_lost_accounts_for_every_event_that_is_not_listed(program: Program, bench: Bench) -> None:
    window = program.receive()
    bench.peer.send(*(Frame(0x100, number.to_bytes(2, "big")) for number in range(1000)))
    program.run(1.0)
    bench.peer.send(Frame(0x101))
    program.run(0.01)
    rows = window.list.rows()
    assert [len(rows), rows[-1][2], rows[-1][4]] == [201, f"{800:X}", "00000101"]


@pytest.mark.conforms("FT-08")
@pytest.mark.parametrize(("align", "word"), [(2, "048C0000"), (3, "24600000")])
def test_identifiers_lie_as_align_says(bench: Bench, registry: RegistryStore, align: int, word: str) -> None:
    registry.set("CID1", "Align", align)
    program = Program(bench)
    window = program.receive()
    bench.peer.send(Frame(0x123))
    program.run(0.01)
    assert [row[4] for row in window.list.rows()] == [word]
    program.leave()


@pytest.mark.conforms("FT-09")
def test_events_cleared_are_gone_and_new_ones_come() -> None:
    listing = Listing()
    for number in range(3):
        listing.append((str(number),))
    listing.clear()
    listing.append(("3",))
    since = listing.since(0, 100)
    assert (since.first, since.start, since.total, since.rows) == (3, 3, 4, [("3",)])


def test_the_newest_are_kept_and_a_viewer_gets_what_it_has_not_seen() -> None:
    listing = Listing()
    for number in range(KEPT + 10):
        listing.append((str(number),))
    since = listing.since(KEPT + 8, 100)
    assert (since.first, since.total, since.rows) == (10, KEPT + 10, [(str(KEPT + 8),), (str(KEPT + 9),)])
    assert listing.since(0, 5).start == KEPT + 5


@pytest.mark.conforms("FT-09")
def test_the_log_has_what_comes_while_it_is_open(program: Program, bench: Bench, tmp_path: Path) -> None:
    window, path = program.receive(), tmp_path / "events.txt"

    def receive(identifier: int) -> None:
        bench.peer.send(Frame(identifier, b"\xaa"))
        program.run(0.01)

    receive(0x100)
    window.list.open_log(path)
    assert window.list.log_name == "events.txt"
    receive(0x101)
    window.list.clear()
    receive(0x102)
    window.list.close_log()
    assert window.list.log_name == ""
    receive(0x103)
    lines = [line.split("\t") for line in path.read_text().splitlines()]
    assert [(line[0], line[4], line[7]) for line in lines] == [
        ("RECEIVED", "00000101", "AA"),
        ("RECEIVED", "00000102", "AA"),
    ]
    assert [row[4] for row in window.list.rows()] == ["00000102", "00000103"]


@pytest.mark.conforms("FT-09")
def test_a_log_overwrites_only_when_told(tmp_path: Path) -> None:
    path = tmp_path / "events.txt"
    path.write_text("precious\n")
    listing = Listing()
    with pytest.raises(FileExistsError):
        listing.open_log(path)
    listing.open_log(path, overwrite=True)
    with pytest.raises(BadValue, match="close it first"):
        listing.open_log(path)
    listing.close_log()
    assert path.read_text() == ""


@pytest.mark.conforms("FT-09")
@pytest.mark.skipif(not FULL.exists(), reason="there is no /dev/full here")
def test_a_log_that_cannot_be_written_ends_and_says_so() -> None:
    listing = Listing()
    listing.open_log(FULL, overwrite=True)
    listing.append(("RECEIVED", "00000001"))
    assert listing.log_name == ""
    assert "No space left on device; the log ends here" in listing.trouble
    listing.append(("RECEIVED", "00000002"))
    assert len(listing.rows()) == 2


@pytest.mark.conforms("FT-09")
def test_overrun_clears_the_controller_s(program: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    window, cleared = program.receive(), []
    monkeypatch.setattr(window.handle.device, "clear_overrun", lambda: cleared.append(True))
    window.clear_overrun()
    assert cleared == [True]


# the event mask


@pytest.mark.conforms("FT-10")
def test_every_type_is_switched_alone_and_at_once(program: Program, bench: Bench) -> None:
    window = program.receive()
    assert window.mask == 0x7FF
    for kind in KINDS:
        window.toggle(kind)
        assert window.mask == 0x7FF & ~kind
        window.toggle(kind)
    assert sum(KINDS) == 0x7FF
    window.toggle(0x001)
    bench.peer.send(Frame(0x100))
    program.run(0.01)
    window.mask = 0x7FF
    bench.peer.send(Frame(0x101))
    program.run(0.01)
    assert [row[4] for row in window.list.rows()] == ["00000101"]


@pytest.mark.conforms("FT-10")
def test_what_waits_and_is_no_longer_wanted_is_lost(program: Program, bench: Bench) -> None:
    window = program.receive()
    bench.peer.send(Frame(0x100), Frame(0x101))
    bench.run(0.01)
    window.mask = 0
    window.mask = 0x7FF
    bench.peer.send(Frame(0x102))
    program.run(0.01)
    assert [(row[2], row[4]) for row in window.list.rows()] == [("2", "00000102")]


@pytest.mark.conforms("FT-10")
@pytest.mark.parametrize("mask", [0x800, 0x1_0000_0000, 0xFFFFFFFF])
def test_impossible_masks_are_refused(program: Program, mask: int) -> None:
    window = program.receive()
    with pytest.raises(BadValue):
        window.mask = mask
    with pytest.raises(BadValue):
        window.toggle(mask)
    assert window.mask == 0x7FF


# the acceptance filter


@pytest.mark.conforms("FT-11")
def test_rows_of_a_new_window_show_the_registry_s_filter(program: Program) -> None:
    window = program.receive(accept=False)
    assert window.filter_rows() == ("0" * 11 + " " + "+" * 16, "")  # ruling 33: the data is not compared
    program.port.set_mode(1)
    assert window.filter_rows().extended == "0" * 29


@pytest.mark.conforms("FT-11")
@pytest.mark.parametrize(
    ("align", "active", "code", "mask", "standard", "extended"),
    [
        (0, 0, 0x24600000, 0x001FFFFF, "00100100011 ++++++++++++++++", "00100100011" + "+" * 18),
        (0, 1, 0x24600000, 0xFFE00000, "00100100011 ++++++++++++++++", "00100100011" + "+" * 18),
        (
            0,
            0,
            0x00000A00,
            0xFFFF00FF,
            "+++++++++++ 00001010++++++++",
            "+" * 16 + "00001010" + "+" * 5,
        ),
        (1, 0, 0x123, 0x00F, "0010010++++", "0" * 18 + "0010010++++"),
        (2, 1, 0x048C0000, 0x1FFC0000, "00100100011 ++++++++++++++++", "00100100011" + "+" * 18),
        (3, 1, 0x24600000, 0xFFE00000, "00100100011 ++++++++++++++++", "00100100011" + "+" * 18),
    ],
)
def test_rows_show_each_bit_under_align_and_mask_active(
    bench: Bench,
    registry: RegistryStore,
    align: int,
    active: int,
    code: int,
    mask: int,
    standard: str,
    extended: str,
) -> None:
    registry.merge({"CID1": {"Align": align, "MaskActive": active, "CanMode2B": 1}})
    program = Program(bench)
    window = program.receive(accept=False)
    window.set_filter(code, mask)
    rows = window.filter_rows()
    assert rows.standard == standard
    assert rows.extended == extended
    assert window.filter == Filter(code, mask, align, active)
    program.leave()


@pytest.mark.conforms("FT-11")
def test_a_filter_acts_when_it_is_set(program: Program, bench: Bench) -> None:
    window = program.receive()
    window.set_filter(0x123 << 21, 0x001FFFFF)
    bench.peer.send(Frame(0x123), Frame(0x124))
    program.run(0.01)
    assert [row[4] for row in window.list.rows()] == ["00000123"]


@pytest.mark.conforms("FT-11")
def test_registry_values_count_once_the_driver_is_loaded_anew(
    program: Program, registry: RegistryStore
) -> None:
    registry.merge({"CID1": {"Align": 1, "MaskActive": 1}})
    window = program.receive(accept=False)
    assert (window.filter.align, window.filter.mask_active) == (0, 0)
