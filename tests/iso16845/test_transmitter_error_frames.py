"""ISO 16845-1, 8.3 to 8.5: error and overload frames of a transmitter, its passive state, bus-off."""

from __future__ import annotations

from tests.iso16845.frames import Spec, lay_out
from tests.iso16845.purposes import shows
from tests.iso16845.scenes import Scene, formats
from tests.iso16845.test_transmitter_frames import JOINING_IDS, joins

PASSIVE = 200


@shows("8.3.1")
def test_dominant_bits_behind_its_flag(kind: str) -> None:
    for fd in formats(kind):
        for bits in (1, 4, 7):
            Scene(kind, fd).disturbed_sender().flag().dominant(bits).between().again().play(received=[])


@shows("8.3.2")
def test_foreign_sof_in_the_third_intermission_bit(kind: str) -> None:
    for fd in formats(kind):
        for id in JOINING_IDS:
            scene = Scene(kind, fd)
            scene.e = scene.e.but(id=id)
            joins(scene.disturbed_sender().flag().recessive(8 + 2), scene.e).play(received=[])


@shows("8.3.3")
def test_disturbed_bit_of_its_active_flag(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 4, 6):
            Scene(kind, fd).disturbed_sender().forced(bit, bit).flag().between().again().play(received=[])


@shows("8.3.4")
def test_dominant_bit_in_its_error_delimiter(kind: str) -> None:
    for fd in formats(kind):
        for bit in (2, 4, 7):
            scene = Scene(kind, fd).disturbed_sender().flag().recessive(bit - 1).dominant(1)
            scene.flag().between().again().play(received=[])


@shows("8.4.1")
def test_overload_in_the_intermission(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 2):
            scene = Scene(kind, fd, tec=PASSIVE)
            scene.ask(scene.other).sends(scene.other.but(esi=fd), ask=False)
            scene.recessive(bit - 1).dominant(1).flag().between().counters(PASSIVE - 1, 0).play(settling=25)


@shows("8.4.2")
def test_overload_behind_a_delimiter(kind: str) -> None:
    for fd in formats(kind):
        scene = (
            Scene(kind, fd, tec=PASSIVE)
            .disturbed_sender(passive=True)
            .passive_flag()
            .recessive(7)
            .dominant(1)
        )
        scene.flag().between().recessive(8).again(passive=True).play(received=[], settling=25)
        scene = Scene(kind, fd, tec=PASSIVE)
        scene.ask(scene.other).sends(scene.other.but(esi=fd), ask=False).dominant(1)
        scene.flag().recessive(7).dominant(1).flag().between().play(received=[], settling=25)


@shows("8.4.3")
def test_foreign_sof_behind_an_overload_frame(kind: str) -> None:
    for fd in formats(kind):
        for id in JOINING_IDS:
            scene = Scene(kind, fd)
            scene.e = scene.e.but(id=id)
            scene.disturbed_sender().flag().recessive(7).dominant(1).flag().recessive(8 + 2)
            joins(scene, scene.e).play(received=[])


@shows("8.4.4")
def test_disturbed_bit_of_its_overload_flag(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 2, 6):
            Scene(kind, fd).overloaded_sender().forced(bit, bit).flag().between().play(received=[])


@shows("8.4.5")
def test_dominant_bit_in_its_overload_delimiter(kind: str) -> None:
    for fd in formats(kind):
        for bit in (2, 4, 7):
            scene = Scene(kind, fd).overloaded_sender().flag().recessive(bit - 1).dominant(1)
            scene.flag().between().play(received=[])


def passive_sender(kind: str, fd: bool) -> Scene:
    """Passive, its frame E disturbed; the passive flag is to come next."""
    return Scene(kind, fd, tec=PASSIVE).disturbed_sender(passive=True)


@shows("8.5.1")
def test_foreign_active_flag_over_its_passive_flag(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 3, 6):
            scene = passive_sender(kind, fd).recessive(bit - 1).dominant(6).recessive(8 + 3)
            scene.lt(scene.other).recessive(3)
            repeated(scene).counters(PASSIVE + 7, 0).play(received=[scene.other])


def repeated(scene: Scene) -> Scene:
    """Its own frame E, error passive."""
    return scene.again(passive=True)


@shows("8.5.2")
def test_frame_in_the_third_intermission_bit(kind: str) -> None:
    for fd in formats(kind):
        scene = passive_sender(kind, fd).dominant(6).recessive(8 + 2)
        scene.lt(scene.other).recessive(3)
        repeated(scene).play(received=[scene.other])


@shows("8.5.3")
def test_dominant_bits_behind_its_passive_flag(kind: str) -> None:
    for fd in formats(kind):
        for bits in (1, 4, 7):
            scene = passive_sender(kind, fd).passive_flag().dominant(bits).recessive(8 + 3)
            scene.lt(scene.other).recessive(3)
            repeated(scene).play(received=[scene.other])


@shows("8.5.4")
def test_receives_in_its_suspend_time(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 4, 8):
            scene = Scene(kind, fd, tec=PASSIVE)
            scene.ask(scene.e).sends(scene.e.but(esi=fd), ask=False).recessive(3 + bit - 1)
            scene.lt(scene.other).play(received=[scene.other])


@shows("8.5.5")
def test_suspend_behind_an_error_frame(kind: str) -> None:
    for fd in formats(kind):
        scene = passive_sender(kind, fd).passive_flag().between().recessive(8)
        repeated(scene).play(received=[])


def two_frames(kind: str, fd: bool) -> Scene:
    """Passive with two frames queued, of which the first goes through."""
    scene = Scene(kind, fd, tec=PASSIVE)
    return scene.ask(scene.other).ask(scene.e).sends(scene.other.but(esi=fd), ask=False)


@shows("8.5.6")
def test_suspend_behind_an_overload_frame(kind: str) -> None:
    for fd in formats(kind):
        scene = two_frames(kind, fd).dominant(1).flag().between().recessive(8)
        repeated(scene).counters(PASSIVE - 2, 0).play(received=[])


@shows("8.5.7")
def test_suspend_behind_a_frame(kind: str) -> None:
    for fd in formats(kind):
        scene = two_frames(kind, fd).recessive(3 + 8)
        repeated(scene).counters(PASSIVE - 2, 0).play(received=[])


@shows("8.5.8")
def test_no_suspend_behind_lost_arbitration(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd, tec=PASSIVE)
        mine, theirs = Spec(0x44A, fd=fd, esi=fd), Spec(0x24A, fd=fd)
        scene.ask(mine.but(esi=False)).lt(theirs, drives=lay_out(mine).levels[:2]).recessive(3)
        scene.sends(mine, ask=False).play(received=[theirs])


@shows("8.5.9")
def test_foreign_sof_is_not_taken_for_its_own(kind: str) -> None:
    for fd in formats(kind):
        for bit in (3, 4, 10, 11):
            scene = passive_sender(kind, fd).passive_flag().recessive(8 + bit - 1)
            scene.lt(scene.other).recessive(3)
            assert scene.other.id > scene.e.id
            repeated(scene).play(received=[scene.other])


@shows("8.5.10")
def test_bus_off_by_an_overload_flag(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd)
        scene.ask(scene.e).disturbed_sender().counters(8, 0).forced(16, *range(1, 17)).counters(136, 0)
        scene.passive_flag().dominant(112).counters(248, 0).recessive(8 + 3 + 8)
        repeated(scene).dominant(1).counters(247, 0).forced(1, 1).counters(255, 0)
        scene.recessive(6 + 7).dominant(1).forced(1, 1).recessive(6 + 8 + 3 + 8)
        assert_off(scene)
        scene.lt(scene.other, ack=False).play(received=[])


def assert_off(scene: Scene) -> None:
    def look() -> None:
        assert scene.iut.off

    scene.check(look)


@shows("8.5.11")
def test_bus_off_lasts_for_128_runs(kind: str) -> None:
    for fd in formats(kind):
        scene = off(kind, fd)
        scene.recessive(128 * 11 - 1)
        assert_off(scene)
        recovers(scene)
        scene = off(kind, fd)
        scene.recessive(10).dominant(1).recessive(21).dominant(1)
        for _ in range(126):
            scene.recessive(11).dominant(1)
        scene.recessive(10)
        assert_off(scene)
        recovers(scene)


def off(kind: str, fd: bool) -> Scene:
    """In bus-off by a bit error in the CRC, its frame still pending; recovery has been asked for."""
    scene = Scene(kind, fd, tec=255)
    bits = lay_out(scene.other.but(esi=fd))
    at = bits.plain("CRC", "0")
    scene.ask(scene.other).sends(bits, change={at: "1"}, until=at, ask=False)
    assert_off(scene)
    return scene.check(scene.iut.recover)


def recovers(scene: Scene) -> None:
    """With the next recessive bit it is error active again with clean counters, and sends its frame."""
    scene.recessive(1).counters(0, 0).sends(scene.other, ask=False).play(received=[])
    assert not scene.iut.off


@shows("8.5.12")
def test_passive_flag_waits_for_six_equal_bits(kind: str) -> None:
    for fd in formats(kind):
        scene = passive_sender(kind, fd).dominant(5).recessive(5).dominant(6).recessive(8).dominant(1)
        scene.flag().between().recessive(8)
        repeated(scene).play(received=[])


@shows("8.5.13")
def test_dominant_bit_in_a_passive_delimiter(kind: str) -> None:
    for fd in formats(kind):
        for bit in (2, 4, 7):
            scene = passive_sender(kind, fd).passive_flag().recessive(bit - 1).dominant(1)
            scene.recessive(6 + 7).dominant(1).flag().between().recessive(8)
            repeated(scene).play(received=[])


@shows("8.5.14")
def test_recovery_takes_31_bits_at_most(kind: str) -> None:
    for fd in formats(kind):
        scene = passive_sender(kind, fd).passive_flag().dominant(6).between().recessive(8)
        repeated(scene).play(received=[])


@shows("8.5.15")
def test_turns_passive_while_its_flag_is_disturbed(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd).disturbed_sender().counters(8, 0).forced(16, *range(1, 17))
        scene.counters(136, 0).passive_flag().between().recessive(8)
        repeated(scene).counters(135, 0).play(received=[])
