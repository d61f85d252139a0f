"""Frames that exist are legal; what is none says which value is wrong."""

from __future__ import annotations

import copy
import inspect
import pickle
import pydoc
import re
from collections.abc import Callable
from typing import Any

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

import canwire
from canwire.errors import BadFrame
from canwire.values import record
from canwire.values.dlc import FD_LENGTHS
from canwire.values.frame import Frame, frame_of_record, record_of_frame, record_to_send
from canwire.values.record import RECORD_SIZE, record_dtype
from canwire.values.records import checked_records, frames_to_array
from tests.cases import each
from tests.uncompiled import load_uncompiled

pytestmark = pytest.mark.core

times = st.integers(0, 2**64 - 1)


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    """Any legal frame, made by the public constructor alone."""
    extended, fd = draw(st.booleans()), draw(st.booleans())
    remote = not fd and draw(st.booleans())
    dlc = draw(st.integers(0, 15))
    length = 0 if remote else FD_LENGTHS[dlc] if fd else min(dlc, 8)
    return Frame(
        draw(st.integers(0, 0x1FFFFFFF if extended else 0x7FF)),
        draw(st.binary(min_size=length, max_size=length)),
        extended=extended,
        remote=remote,
        fd=fd,
        bit_rate_switch=fd and draw(st.booleans()),
        error_state_indicator=fd and draw(st.booleans()),
        dlc=dlc,
        timestamp_ns=draw(times),
        self_received=draw(st.booleans()),
    )


def everything(frame: Frame) -> tuple[object, ...]:
    """What two equal frames need not share comes last."""
    format_ = (frame.extended, frame.remote, frame.fd, frame.bit_rate_switch, frame.error_state_indicator)
    return (frame.id, frame.data, frame.dlc, *format_, frame.timestamp_ns, frame.self_received)


def changed(frame: Frame, what: str) -> Frame:
    """The same but for one thing."""
    values = {name: getattr(frame, name) for name in inspect.signature(Frame).parameters}
    other = {
        "id": frame.id ^ 1,
        "data": frame.data[:-1] + bytes(byte ^ 1 for byte in frame.data[-1:]),
        "timestamp_ns": frame.timestamp_ns ^ 1 << 40,
        "self_received": not frame.self_received,
    }
    return Frame(**values | {what: other[what]})


class TestRefusals:
    """Each message names the value at fault and what would be right."""

    @each(("make", "named"), [
        (lambda: Frame(0x800), ["0x800", "11 bits", "extended=True"]),
        (lambda: Frame(0x1FFFFFFF), ["0x1fffffff", "11 bits", "extended=True"]),
        (lambda: Frame(0x20000000, extended=True), ["0x20000000", "29 bits"]),
        (lambda: Frame(0x20000000), ["0x20000000", "29 bits"]),
        (lambda: Frame(2**70, extended=True), ["29 bits"]),
        (lambda: Frame(-1), ["-0x1", "29 bits"]),
        (lambda: Frame("123"), ["'123'", "whole number"]),  # type: ignore[arg-type]
        (lambda: Frame(1.5), ["1.5", "whole number"]),  # type: ignore[arg-type]
        (lambda: Frame(None), ["None", "whole number"]),  # type: ignore[arg-type]
        (lambda: Frame(1, bytes(9)), ["9 bytes", "at most 8", "fd=True"]),
        (lambda: Frame(1, bytes(64)), ["64 bytes", "at most 8", "fd=True"]),
        (lambda: Frame(1, bytes(9), fd=True), ["9 bytes", "12, 16"]),
        (lambda: Frame(1, bytes(63), fd=True), ["63 bytes", "64"]),
        (lambda: Frame(1, bytes(65), fd=True), ["65 bytes", "64"]),
        (lambda: Frame(1, bytes(1000), fd=True), ["1000 bytes", "64"]),
        (lambda: Frame(1, remote=True, fd=True), ["remote", "FD"]),
        (lambda: Frame(1, b"\1\2", remote=True), ["remote", "2 bytes", "dlc"]),
        (lambda: Frame(1, b"\1\2", dlc=3), ["dlc 3", "3 bytes", "data has 2"]),
        (lambda: Frame(1, b"\1\2", dlc=0), ["dlc 0", "data has 2"]),
        (lambda: Frame(1, bytes(7), dlc=9), ["dlc 9", "8 bytes", "data has 7"]),
        (lambda: Frame(1, bytes(8), fd=True, dlc=9), ["dlc 9", "12 bytes", "data has 8"]),
        (lambda: Frame(1, bytes(64), fd=True, dlc=14), ["dlc 14", "48 bytes", "data has 64"]),
        (lambda: Frame(1, dlc=16), ["dlc 16", "0 to 15"]),
        (lambda: Frame(1, dlc=-1), ["dlc -1", "0 to 15"]),
        (lambda: Frame(1, remote=True, dlc=16), ["dlc 16", "0 to 15"]),
        (lambda: Frame(1, remote=True, dlc=2**40), ["dlc 1099511627776", "0 to 15"]),
        (lambda: Frame(1, dlc="8"), ["dlc '8'", "0 to 15"]),  # type: ignore[arg-type]
        (lambda: Frame(1, bytes(8), dlc=8.0), ["dlc 8.0", "0 to 15"]),  # type: ignore[arg-type]
        (lambda: Frame(1, bit_rate_switch=True), ["bit_rate_switch", "fd=True"]),
        (lambda: Frame(1, error_state_indicator=True), ["error_state_indicator", "fd=True"]),
        (lambda: Frame(1, timestamp_ns=-1), ["timestamp_ns -1", "2**64"]),
        (lambda: Frame(1, timestamp_ns=2**64), ["timestamp_ns 18446744073709551616", "2**64"]),
        (lambda: Frame(1, timestamp_ns=0.5), ["timestamp_ns 0.5", "whole number"]),  # type: ignore[arg-type]
        (lambda: Frame(1, timestamp_ns=None), ["timestamp_ns None", "whole number"]),  # type: ignore[arg-type]
        (lambda: Frame(1, "text"), ["'text'", "bytes"]),  # type: ignore[arg-type]
        (lambda: Frame(1, 8), ["data 8", "bytes"]),  # type: ignore[arg-type]
        (lambda: Frame(1, None), ["data None", "bytes"]),  # type: ignore[arg-type]
        (lambda: Frame(1, [1, 256]), ["[1, 256]", "256"]),  # type: ignore[arg-type]
        (lambda: Frame(1, [1, "2"]), ["[1, '2']"]),  # type: ignore[arg-type]
    ])  # fmt: skip
    def test_says_what_is_wrong(self, make: Callable[[], Frame], named: list[str]) -> None:
        with pytest.raises(BadFrame) as refusal:
            make()
        assert [part for part in named if part not in str(refusal.value)] == []

    def test_is_a_value_error(self) -> None:
        with pytest.raises(ValueError, match="0x800"):
            Frame(0x800)

    @each("size", [0, 1, 79, 81])
    def test_record_of_another_size(self, size: int) -> None:
        with pytest.raises(BadFrame, match=f"80 bytes, not {size}"):
            frame_of_record(bytes(size))


class TestMaking:
    def test_defaults(self) -> None:
        assert everything(Frame(0)) == (0, b"", 0, False, False, False, False, False, 0, False)

    @each("length", range(9))
    def test_dlc_of_classic_data(self, length: int) -> None:
        assert Frame(1, bytes(length)).dlc == length

    @each("dlc", range(16))
    def test_dlc_of_fd_data(self, dlc: int) -> None:
        assert Frame(1, bytes(FD_LENGTHS[dlc]), fd=True).dlc == dlc

    @each("dlc", range(8, 16))
    def test_codes_above_8_mean_8_classic_bytes(self, dlc: int) -> None:
        frame = Frame(1, bytes(8), dlc=dlc)
        assert (frame.dlc, len(frame.data)) == (dlc, 8)
        assert (frame == Frame(1, bytes(8))) is (dlc == 8)

    @pytest.mark.conforms("G-03")
    @each("dlc", range(16))
    def test_remote_frame_keeps_its_dlc_and_has_no_data(self, dlc: int) -> None:
        frame = Frame(1, remote=True, dlc=dlc)
        assert (frame.remote, frame.dlc, frame.data) == (True, dlc, b"")

    @each("data", [bytearray(b"\1\2"), memoryview(b"\1\2"), [1, 2], (1, 2)])
    def test_takes_other_forms_of_bytes(self, data: bytes) -> None:
        assert Frame(1, data).data == b"\1\2"
        assert type(Frame(1, data).data) is bytes

    def test_keeps_its_own_copy(self) -> None:
        data = bytearray(b"\1\2")
        frame = Frame(1, data)
        data[0] = 9
        assert frame.data == b"\1\2"

    @pytest.mark.conforms("G-02")
    def test_the_format_is_no_matter_of_size(self) -> None:
        assert Frame(0x123, extended=True).extended
        assert Frame(0x123, extended=True) != Frame(0x123)


class TestFrozen:
    @each(
        "name",
        ["id", "data", "dlc", "extended", "remote", "fd", "bit_rate_switch", "error_state_indicator",
         "timestamp_ns", "self_received", "anything"],
    )  # fmt: skip
    def test_no_attribute_can_be_set(self, name: str) -> None:
        frame = Frame(0x123, b"\1")
        with pytest.raises(AttributeError):
            setattr(frame, name, 1)
        assert everything(frame) == everything(Frame(0x123, b"\1"))

    def test_no_attribute_can_be_deleted(self) -> None:
        frame = Frame(0x123, b"\1")
        with pytest.raises(AttributeError):
            del frame.id


class TestEquality:
    @given(frames())
    def test_the_time_and_the_way_it_came_take_no_part(self, frame: Frame) -> None:
        record_ = record_of_frame(frame)
        later = frame_of_record(bytes(8) + record_[8:])
        assert later == frame
        assert hash(later) == hash(frame)

    @given(frames(), frames())
    def test_equal_means_the_same_on_the_wire(self, one: Frame, other: Frame) -> None:
        assert (one == other) is (everything(one)[:-2] == everything(other)[:-2])

    @each(
        "other",
        [Frame(0x124, b"\1"), Frame(0x123, b"\2"), Frame(0x123, b"\1\0"), Frame(0x123, b"\1", extended=True),
         Frame(0x123, b"\1", fd=True), Frame(0x123, remote=True, dlc=1)],
    )  # fmt: skip
    def test_any_difference_counts(self, other: Frame) -> None:
        assert Frame(0x123, b"\1") != other

    def test_switch_and_indicator_count(self) -> None:
        plain = Frame(1, fd=True)
        assert plain != Frame(1, fd=True, bit_rate_switch=True)
        assert plain != Frame(1, fd=True, error_state_indicator=True)

    def test_nothing_else_is_equal(self) -> None:
        assert Frame(1) != 1
        assert Frame(1) != (1, b"")
        assert (Frame(1) == None) is False  # noqa: E711

    def test_there_is_no_order(self) -> None:
        with pytest.raises(TypeError):
            Frame(1) < Frame(2)  # type: ignore[operator]  # noqa: B015


class TestRoundTrips:
    @given(frames())
    def test_repr(self, frame: Frame) -> None:
        again = eval(repr(frame), {"Frame": Frame})
        assert again == frame
        assert everything(again) == everything(frame)

    def test_repr_is_short(self) -> None:
        assert repr(Frame(0x123, b"\x11\x22")) == 'Frame(0x123, bytes.fromhex("1122"))'
        assert repr(Frame(0x123, extended=True)) == "Frame(0x00000123, extended=True)"
        assert repr(Frame(0x7, remote=True, dlc=4)) == "Frame(0x007, remote=True, dlc=4)"

    @given(frames(), st.integers(0, pickle.HIGHEST_PROTOCOL))
    def test_pickle(self, frame: Frame, protocol: int) -> None:
        again = pickle.loads(pickle.dumps(frame, protocol))
        assert everything(again) == everything(frame)

    @given(frames())
    def test_copy(self, frame: Frame) -> None:
        assert everything(copy.copy(frame)) == everything(copy.deepcopy(frame)) == everything(frame)

    @given(frames())
    def test_record(self, frame: Frame) -> None:
        block = record_of_frame(frame)
        assert len(block) == RECORD_SIZE
        for form in (block, bytearray(block), memoryview(block)):
            assert everything(frame_of_record(form))[:-1] == everything(frame)[:-1]

    @given(frames(), st.sampled_from(["id", "data", "timestamp_ns", "self_received"]))
    def test_records_that_differ_in_one_thing_are_not_mixed_up(self, frame: Frame, what: str) -> None:
        """Receivers of one frame share it."""
        for wanted in (frame, changed(frame, what), frame):
            flags = record.SELF_RECEPTION if wanted.self_received else 0
            read = frame_of_record(record_to_send(wanted, flags, wanted.timestamp_ns))
            assert everything(read) == everything(wanted)

    @given(frames())
    def test_record_as_numpy_sees_it(self, frame: Frame) -> None:
        row = numpy.frombuffer(record_of_frame(frame), record_dtype())[0]
        info = int(row["info"])
        assert (int(row["time_ns"]), int(row["id"])) == (frame.timestamp_ns, frame.id)
        assert row["data"].tobytes() == frame.data.ljust(64, b"\0")
        assert (info & record.DLC_MASK) >> record.DLC_SHIFT == frame.dlc
        assert info & record.TYPE_MASK == 0
        bits = {
            "extended": record.EXTENDED,
            "remote": record.REMOTE,
            "fd": record.EXTENDED_DATA_LENGTH,
            "bit_rate_switch": record.FAST_DATA_RATE,
            "error_state_indicator": record.ERROR_STATE_INDICATOR,
        }
        assert {name: bool(info & bit) for name, bit in bits.items()} == {
            name: getattr(frame, name) for name in bits
        }

    @given(st.binary(min_size=80, max_size=80))
    def test_foreign_records_give_legal_frames_or_none(self, block: bytes) -> None:
        try:
            frame = frame_of_record(block)
        except BadFrame:
            return
        assert eval(repr(frame), {"Frame": Frame}) == frame


class TestArrays:
    @given(st.lists(frames(), max_size=8))
    def test_frames_to_array(self, many: list[Frame]) -> None:
        array = frames_to_array(list(many))
        assert array.dtype == record_dtype()
        untimed = [bytes(8) + record_of_frame(frame)[8:] for frame in many]  # a sender's time word is a delay
        assert array.tobytes() == b"".join(untimed)

    @given(st.lists(frames(), max_size=8), st.sampled_from([0, record.SINGLE_SHOT, record.SELF_RECEPTION]))
    def test_checked_records_keeps_legal_frames(self, many: list[Frame], flags: int) -> None:
        array = frames_to_array(list(many))
        checked = checked_records(array, fd=True, flags=flags)
        assert not numpy.shares_memory(checked, array)
        assert [frame_of_record(row.tobytes()) for row in checked] == many
        assert (checked["info"] == array["info"] | flags).all()
        assert (checked["time_ns"] == array["time_ns"]).all()

    @given(st.lists(frames(), min_size=1, max_size=4), st.binary(min_size=64, max_size=64))
    def test_checked_records_cleans_what_lies_behind_the_data(
        self, many: list[Frame], rubbish: bytes
    ) -> None:
        array = frames_to_array(list(many))
        for row, frame in zip(array, many, strict=True):
            row["data"] = list(frame.data + rubbish[len(frame.data) :])
        array["info"] |= record.OVERRUN | record.SELF_RECEPTION | record.CONFIRM | 0xFF << record.ACCEPT_SHIFT
        checked = checked_records(array, fd=True, flags=0)
        assert checked["data"].tobytes() == frames_to_array(list(many))["data"].tobytes()
        assert (checked["info"] == frames_to_array(list(many))["info"]).all()

    @each(("info", "id", "fd", "what"), [
        (0, 0x800, True, "identifier"),
        (record.EXTENDED, 0x20000000, True, "identifier"),
        (0, record.NO_ID, True, "identifier"),
        (record.EXTENDED_DATA_LENGTH, 1, False, "FD frame on a classic line"),
        (record.EXTENDED_DATA_LENGTH | record.REMOTE, 1, True, "remote frame that is FD"),
        (1, 1, True, "no data or remote frame"),
        (record.FAST_DATA_RATE, 1, True, "without FD"),
        (record.ERROR_STATE_INDICATOR, 1, True, "without FD"),
    ])  # fmt: skip
    def test_checked_records_names_the_first_at_fault(self, info: int, id: int, fd: bool, what: str) -> None:
        array = frames_to_array([Frame(1), Frame(2), Frame(3), Frame(4)])
        array[2]["info"], array[2]["id"] = info, id
        array[3]["info"], array[3]["id"] = info, id
        before = array.tobytes()
        with pytest.raises(BadFrame, match=f"record 2 .*{id:#x}.*{what}"):
            checked_records(array, fd=fd, flags=0)
        assert array.tobytes() == before

    def test_checked_records_wants_records(self) -> None:
        with pytest.raises(TypeError, match="record_dtype"):
            checked_records(numpy.zeros(3, "u8"), fd=False, flags=0)


@pytest.mark.finding("newcomer F11")
class TestHelp:
    def test_signature_is_that_of_the_constructor(self) -> None:
        here = inspect.signature(Frame)
        with load_uncompiled(canwire) as twin:
            there = inspect.signature(twin.Frame.__init__)
        assert str(here).startswith(
            "(id: 'int', data: 'bytes | bytearray | memoryview' = b'', *, extended: 'bool' = False"
        )
        declared = {name: one for name, one in there.parameters.items() if name not in ("self", "unknown")}
        assert list(here.parameters) == list(declared)
        differing = [name for name, one in declared.items() if here.parameters[name] != one]
        assert differing == [
            "id"
        ]  # which may be missing as far as the interpreter is concerned, to be told what to do
        assert here.parameters["id"].default is inspect.Parameter.empty

    def test_help_shows_keywords_and_an_example(self) -> None:
        shown = pydoc.plain(pydoc.render_doc(Frame))
        assert re.search(r"Frame\([\s|]*id: 'int',[\s|]*data: ", shown)  # from Python 3.13 on each has a line
        assert '>>> Frame(0x123, b"\\x11\\x22")' in shown

    @each(("given", "said"), [
        ({"arbitration_id": 1}, "Frame() has no argument 'arbitration_id': what python-can calls arbitration_id is id"),
        ({"is_extended_id": True}, "is extended here (False unless given: the reverse of python-can)"),
        ({"is_fd": True}, "is fd here"),
        ({"timestamp": 1.0}, "is timestamp_ns here, in whole nanoseconds"),
        ({"extendet": True}, "no argument 'extendet'; did you mean 'extended'?"),
        ({"qqq": 1}, "no argument 'qqq'; it has id, data, extended"),
    ])  # fmt: skip
    def test_unknown_arguments_are_told_what_to_write(self, given: dict[str, Any], said: str) -> None:
        with pytest.raises(TypeError) as refusal:
            Frame(**{"id": 1, **given})
        assert said in str(refusal.value)

    def test_an_identifier_there_must_be(self) -> None:
        with pytest.raises(BadFrame, match=r"a frame needs an identifier: Frame\(0x123"):
            Frame()
