"""ISO 16845-1, 7.3 to 7.5: error and overload frames of a receiver, and its passive state."""

from __future__ import annotations

from tests.iso16845.purposes import shows
from tests.iso16845.scenes import Scene, formats


@shows("7.3.1")
def test_dominant_bits_behind_its_flag(kind: str) -> None:
    for fd in formats(kind):
        for bits in (1, 4, 7):
            Scene(kind, fd).disturbed().flag().dominant(bits).between().play(received=[])


@shows("7.3.2")
def test_frame_in_the_third_intermission_bit_behind_an_error_frame(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd)
        scene.disturbed().flag().recessive(8 + 2).lt(scene.other).play(received=[scene.other])


@shows("7.3.3")
def test_disturbed_bit_of_its_active_flag(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 3, 6):
            Scene(kind, fd).disturbed().forced(bit, bit).flag().between().play(received=[])


@shows("7.3.4")
def test_dominant_bit_in_its_error_delimiter(kind: str) -> None:
    for fd in formats(kind):
        for bit in (2, 4, 7):
            scene = Scene(kind, fd).disturbed().flag().recessive(bit - 1).dominant(1)
            scene.flag().between().play(received=[])


@shows("7.4.1")
def test_overload_in_the_intermission(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 2):
            scene = Scene(kind, fd)
            scene.lt(scene.other).recessive(bit - 1).dominant(1).flag().between()
            scene.counters(0, 0).play(received=[scene.other])


@shows("7.4.2")
def test_overload_behind_the_last_bit_of_a_frame(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd)
        scene.overloaded().flag().between().counters(0, 0).play(received=[scene.other])


@shows("7.4.3")
def test_overload_behind_a_delimiter(kind: str) -> None:
    for fd in formats(kind):
        Scene(kind, fd).disturbed().flag().recessive(7).dominant(1).flag().between().play(received=[])
        scene = Scene(kind, fd)
        scene.lt(scene.other).dominant(1).flag().recessive(7).dominant(1).flag().between()
        scene.play(received=[scene.other])


@shows("7.4.4")
def test_disturbed_bit_of_its_overload_flag(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 3, 6):
            scene = Scene(kind, fd)
            scene.overloaded().forced(bit, bit).flag().between().play(received=[scene.other])


@shows("7.4.5")
def test_dominant_bit_in_its_overload_delimiter(kind: str) -> None:
    for fd in formats(kind):
        for bit in (2, 4, 7):
            scene = Scene(kind, fd)
            scene.overloaded().flag().recessive(bit - 1).dominant(1).flag().between()
            scene.counters(rec=1).play(received=[scene.other])


@shows("7.4.6")
def test_overload_in_the_intermission_of_an_error_frame(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 2):
            scene = Scene(kind, fd).disturbed().flag().recessive(8 + bit - 1).dominant(1)
            scene.flag().between().counters(rec=1).play(received=[])


@shows("7.4.7")
def test_overload_in_the_intermission_of_an_overload_frame(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 2):
            scene = Scene(kind, fd)
            scene.lt(scene.other).dominant(1).flag().recessive(8 + bit - 1).dominant(1).flag().between()
            scene.counters(0, 0).play(received=[scene.other])


@shows("7.5.1")
def test_passive_flag_is_complete_after_six_equal_bits(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 3, 6):
            scene = Scene(kind, fd, tec=136)
            scene.disturbed().recessive(bit - 1).dominant(6).recessive(8 + 2).lt(scene.other)
            scene.play(received=[scene.other])


@shows("7.5.2")
def test_frame_in_the_third_intermission_bit_behind_a_passive_flag(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd, tec=136)
        scene.disturbed().passive_flag().recessive(8 + 2).lt(scene.other).play(received=[scene.other])


@shows("7.5.3")
def test_dominant_bits_behind_its_passive_flag(kind: str) -> None:
    for fd in formats(kind):
        for bits in (1, 4, 7):
            scene = Scene(kind, fd, tec=136)
            scene.disturbed().passive_flag().dominant(bits).recessive(8 + 2).lt(scene.other)
            scene.play(received=[scene.other])


@shows("7.5.4")
def test_stays_passive_through_errors(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd, tec=136)
        for _ in range(9):
            scene.disturbed().passive_flag().between()
        scene.counters(136, 9).play(received=[])


@shows("7.5.5")
def test_dominant_bits_inside_its_passive_flag(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 3, 6):
            scene = Scene(kind, fd, tec=136).disturbed().recessive(bit - 1).dominant(5)
            scene.recessive(6 + 7).dominant(1).flag().between().play(received=[])


@shows("7.5.6")
def test_dominant_bit_in_a_passive_delimiter(kind: str) -> None:
    for fd in formats(kind):
        for bit in (2, 4, 7):
            scene = Scene(kind, fd, tec=136).disturbed().passive_flag().recessive(bit - 1).dominant(1)
            scene.recessive(6 + 7).dominant(1).flag().between().counters(rec=2).play(received=[])


@shows("7.5.7")
def test_turns_passive_while_its_flag_is_disturbed(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd)
        scene.disturbed().counters(rec=1).forced(17, *range(1, 18)).counters(rec=137)
        scene.passive_flag().recessive(8 + 3).lt(scene.other).play(received=[scene.other])
