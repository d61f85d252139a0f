"""What `canwire gen` makes of its patterns, and when."""

from __future__ import annotations

import random
from itertools import islice
from pathlib import Path

import pytest

from canwire import BadDescription, BadValue, BitTiming, Frame, LineMode
from canwire.commands.gen.cyclic import CyclicMessages
from canwire.commands.gen.pace import by_load, every
from canwire.commands.gen.patterns import Kind, frames
from tests.cases import each

CAR = str(Path(__file__).parents[1] / "car.dbc")


ONE = Kind()


def made(
    count: int, id: str = "123", length: str = "8", data: str = "random", kind: Kind = ONE, seed: int = 1
) -> list[Frame]:
    return list(islice(frames(id, length, data, kind, random.Random(seed)), count))


@pytest.mark.conforms("PC-05")
@each(
    ("id", "kind", "found"),
    [
        ("123", Kind(), [(0x123, False)] * 4),
        ("123,7FF", Kind(), [(0x123, False), (0x7FF, False)] * 2),
        ("100-102", Kind(), [(0x100, False), (0x101, False), (0x102, False), (0x100, False)]),
        ("00000123", Kind(), [(0x123, True)] * 4),
        ("123", Kind(extended=True), [(0x123, True)] * 4),
    ],
)
def test_identifiers(id: str, kind: Kind, found: list[tuple[int, bool]]) -> None:
    assert [(frame.id, frame.extended) for frame in made(4, id, kind=kind)] == found


@pytest.mark.conforms("PC-05")
def test_random_identifiers_stay_within() -> None:
    assert {frame.id for frame in made(300, "random:100-103")} == {0x100, 0x101, 0x102, 0x103}
    assert max(frame.id for frame in made(300, "random")) <= 0x7FF
    wide = made(300, "random", kind=Kind(extended=True))
    assert all(frame.extended for frame in wide)
    assert max(frame.id for frame in wide) > 0x7FF


@pytest.mark.conforms("PC-05")
def test_data() -> None:
    assert [frame.data for frame in made(2, data="11.22")] == [b"\x11\x22"] * 2
    assert [frame.data for frame in made(3, length="2", data="increment")] == [b"\0\0", b"\1\0", b"\2\0"]
    assert made(257, length="1", data="increment")[256].data == b"\0"
    drawn = {frame.data for frame in made(200, data="1xAA")}
    assert all(data[0] >> 4 == 1 and data[1] == 0xAA for data in drawn)
    assert len(drawn) == 16
    assert [len(frame.data) for frame in made(10, length="0-8")] == [*range(9), 0]


@pytest.mark.conforms("PC-05")
def test_kinds() -> None:
    lengths = {len(frame.data) for frame in made(300, length="random", kind=Kind(fd=True))}
    assert lengths == {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64}
    fast = made(1, kind=Kind(fd=True, bit_rate_switch=True, error_state_indicator=True))[0]
    assert (fast.fd, fast.bit_rate_switch, fast.error_state_indicator) == (True, True, True)
    asked = made(1, length="4", kind=Kind(remote=True))[0]
    assert (asked.remote, asked.dlc, asked.data) == (True, 4, b"")
    raw = made(1, kind=Kind(dlc=12))[0]
    assert (raw.dlc, len(raw.data)) == (12, 8)


def test_the_same_seed_gives_the_same_frames() -> None:
    assert made(50, "random", "random", seed=7) == made(50, "random", "random", seed=7)
    assert made(50, "random", "random", seed=7) != made(50, "random", "random", seed=8)


@each(
    ("words", "why"),
    [
        ({"id": "800"}, "no identifier of 11 bits"),
        ({"id": "x"}, "--id 'x': 123"),
        ({"id": "200-100"}, "from the lower to the higher"),
        ({"id": "1-2-3"}, "from the lower to the higher"),
        ({"length": "9"}, "--length 9: bytes, 0 to 8"),
        ({"length": "eight"}, "--length eight"),
        ({"length": "9", "kind": Kind(fd=True)}, "--length 9: bytes, 0 to 64"),
        ({"data": "1"}, "--data 1: pairs of hex digits"),
        ({"data": "112233445566778899"}, "9 bytes; one of 0, 1"),
        ({"kind": Kind(remote=True, fd=True)}, "no remote frames"),
        ({"kind": Kind(dlc=8)}, "--dlc 8: 9 to 15"),
        ({"kind": Kind(dlc=9), "data": "11"}, "8 bytes with --dlc 9"),
    ],
)
def test_what_is_no_pattern(words: dict[str, object], why: str) -> None:
    with pytest.raises(BadValue, match=why):
        made(1, **words)  # type: ignore[arg-type]


def test_a_share_of_the_bus_is_that_of_the_bits_on_the_wire() -> None:
    mode = LineMode(BitTiming.for_bit_rate(500_000), BitTiming.for_bit_rate(2_000_000))
    zeros, mixed = Frame(0, bytes(8)), Frame(0x555, b"\x55" * 8)
    assert (
        111 <= round(by_load(100, mode)(mixed) * 500_000) <= 114
    )  # 108 and the intermission; hardly a stuff bit
    assert by_load(50, mode)(zeros) == pytest.approx(2 * by_load(100, mode)(zeros))
    assert by_load(50, mode)(zeros) > by_load(50, mode)(mixed)
    fast = Frame(1, bytes(64), fd=True, bit_rate_switch=True)
    slow = Frame(1, bytes(64), fd=True)
    assert by_load(100, mode)(fast) < by_load(100, mode)(slow) / 2
    assert every(0.25)(zeros) == 0.25


@each("percent", [0, -1, 100.1, float("nan")])
def test_no_share(percent: float) -> None:
    with pytest.raises(BadValue, match="--load"):
        by_load(percent, LineMode(BitTiming.for_bit_rate(500_000)))


def test_a_line_without_a_rate_has_no_share() -> None:
    with pytest.raises(BadValue, match="no bit rate yet"):
        by_load(40, LineMode(None))


# by a database


@pytest.mark.conforms("PF-15")
def test_messages_come_in_their_cycle_times() -> None:
    messages = CyclicMessages(CAR, [], None, random.Random(1))
    assert (len(messages), messages.without) == (2, ["Rare"])
    now_s, times = 0.0, {0x100: [], 0x101: []}  # type: ignore[var-annotated]
    for gap_s, frame in islice(messages.plan(), 70):
        now_s += gap_s
        times[frame.id].append(round(now_s * 1000))
    assert times[0x100] == [10 * k for k in range(50)]
    assert times[0x101] == [25 * k for k in range(20)]


def test_their_signals_have_values_that_the_database_allows() -> None:
    import cantools

    known = cantools.database.load_file(CAR)
    messages = CyclicMessages(CAR, ["Engine", "Chosen"], None, random.Random(1))
    seen = set()
    for _, frame in islice(messages.plan(), 200):
        values = known.decode_message(frame.id, frame.data)
        if frame.id == 0x100:
            assert 0 <= values["Speed"] <= 8000
            assert -100 <= values["Torque"] <= 100
        else:
            assert ("One" in values) != ("Other" in values)
            seen |= values.keys()
    assert seen == {"Which", "One", "Other"}


def test_every_message_of_a_car_can_be_encoded_as_its_database_says() -> None:
    """Whatever is drawn is within the ranges: nothing is refused, and cantools reads what was meant."""
    import cantools

    path = Path(__file__).parents[2] / "databases" / "data" / "vehicle.dbc"
    known = cantools.database.load_file(path)
    messages = CyclicMessages(str(path), [], 0.1, random.Random(3))
    for _, frame in islice(messages.plan(), 3 * len(messages)):
        message = known.get_message_by_frame_id(frame.id)
        values = known.decode_message(frame.id, frame.data, decode_choices=False)
        for signal in message.signals:
            if signal.name in values and not signal.is_multiplexer:
                assert signal.minimum is None or values[signal.name] >= signal.minimum - 1e-6 * abs(
                    signal.scale
                )
                assert signal.maximum is None or values[signal.name] <= signal.maximum + 1e-6 * abs(
                    signal.scale
                )


def test_what_needs_several_frames_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "long.dbc"
    long = 'BO_ 1 Long: 70 Vector__XXX\n SG_ A : 0|8@1+ (1,0) [0|0] "" Vector__XXX\n'
    path.write_text(f'VERSION ""\nBU_:\n{long}' + long.replace("BO_ 1 Long: 70", "BO_ 2 Short: 8"))
    messages = CyclicMessages(str(path), [], 0.1, random.Random(1))
    assert (len(messages), messages.too_long) == (1, ["Long"])


def test_messages_that_are_not_there() -> None:
    with pytest.raises(BadValue, match=r"--message: .*: no message 'Engin'; did you mean Engine"):
        CyclicMessages(CAR, ["Engin"], None, random.Random(1))
    with pytest.raises(BadValue, match="no message has a cycle time"):
        CyclicMessages(CAR, ["Rare"], None, random.Random(1))
    assert len(CyclicMessages(CAR, ["Rare"], 0.5, random.Random(1))) == 1
    with pytest.raises(BadDescription, match=r"nowhere\.dbc: No such file"):
        CyclicMessages("nowhere.dbc", [], None, random.Random(1))
