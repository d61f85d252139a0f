"""Notes that programs leave for each other: whose they are, what goes with whom, and how many there may be."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from canwire import BadValue, LimitReached
from canwire.boards.config.limits import LimitsConfig
from canwire.hub.owner.notes import Notes
from canwire.hub.owner.session import Session
from tests.cases import each

ROOM = 3


def session(name: str) -> Session:
    """A client, of which notes know who it is."""
    return cast("Session", SimpleNamespace(name=name))


@pytest.fixture
def notes() -> Notes:
    return Notes(LimitsConfig(notes=ROOM))


def kept(notes: Notes) -> dict[str, bytes]:
    return dict(notes.beginning(""))


def test_only_notes_that_leave_go_with_their_writer(notes: Notes) -> None:
    one, other = session("one"), session("other")
    notes.set("stays", b"1", one)
    notes.set("leaves", b"2", one, leaves=True)
    notes.set("other's", b"3", other, leaves=True)
    notes.leave(one)
    assert kept(notes) == {"stays": b"1", "other's": b"3"}
    notes.leave(one)  # a second time changes nothing
    notes.leave(other)
    assert kept(notes) == {"stays": b"1"}


@each("first", [False, True])
@each("then", [False, True])
@each("by", ["itself", "another"])
def test_what_was_said_last_of_a_note_counts(first: bool, then: bool, by: str) -> None:
    """A note belongs to whoever wrote it last, and leaves if that was said then."""
    notes = Notes(LimitsConfig(notes=ROOM))
    one, other = session("one"), session("other")
    writer = one if by == "itself" else other
    notes.set("note", b"1", one, leaves=first)
    notes.set("note", b"2", writer, leaves=then)
    if writer is other:
        notes.leave(one)
        assert notes.get("note") == b"2"
    notes.leave(writer)
    assert notes.get("note") == (b"" if then else b"2")


def test_a_note_that_was_taken_away_and_written_anew_does_not_leave(notes: Notes) -> None:
    one = session("one")
    notes.set("note", b"1", one, leaves=True)
    notes.set("note", b"", one)
    assert kept(notes) == {}
    notes.set("note", b"2", one)
    notes.leave(one)
    assert kept(notes) == {"note": b"2"}


def test_each_client_has_its_own_room(notes: Notes) -> None:
    one, other = session("one"), session("other")
    for number in range(ROOM):
        notes.set(f"{number}", b"x", one)
    with pytest.raises(LimitReached, match=f"one has {ROOM} of {ROOM} notes"):
        notes.set("more", b"x", one)
    notes.set("more", b"", one)  # none is there: nothing happens
    notes.set("0", b"another text", one)  # which takes no more room
    notes.set("1", b"", one)
    notes.set("more", b"x", one)
    notes.set("other's", b"y", other)
    with pytest.raises(LimitReached):
        notes.set("other's", b"mine", one)
    assert kept(notes) == {"2": b"x", "0": b"another text", "more": b"x", "other's": b"y"}


def test_of_those_who_left_the_latest_notes_stay(notes: Notes) -> None:
    """Four times the room of one client; a note that somebody takes over is not counted any more."""
    heir = session("heir")
    for number in range(4 * ROOM):
        writer = session(f"{number}")
        notes.set(f"note {number}", b"x", writer)
        notes.leave(writer)
    assert len(kept(notes)) == 4 * ROOM
    notes.set("note 0", b"mine", heir)
    last = session("last")
    for name in ("last", "very last"):
        notes.set(name, b"x", last)
    notes.leave(last)
    assert sorted(kept(notes)) == sorted(
        ["note 0", *(f"note {number}" for number in range(2, 4 * ROOM)), "last", "very last"]
    )


def test_names_and_texts_have_a_largest_length(notes: Notes) -> None:
    one = session("one")
    notes.set("n" * 64, b"t" * 1024, one)
    for name, value in (("n" * 65, b"t"), ("n", b"t" * 1025)):
        with pytest.raises(BadValue, match="up to 64 characters, 1024 bytes each"):
            notes.set(name, value, one)
    assert kept(notes) == {"n" * 64: b"t" * 1024}


def test_notes_are_found_by_how_their_names_begin(notes: Notes) -> None:
    one = session("one")
    for name in ("gateway/a", "gateway/b", "gate"):
        notes.set(name, name.encode(), one)
    assert notes.beginning("gateway/") == (("gateway/a", b"gateway/a"), ("gateway/b", b"gateway/b"))
    assert notes.beginning("b") == ()
    assert (notes.get("gate"), notes.get("gat")) == (b"gate", b"")
