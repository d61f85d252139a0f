"""Cuts of every length and direction, at both ends, with times handed in: nobody gives up before 30 s are over."""

from __future__ import annotations

import pytest

from canwire.hub.links.network import wire
from canwire.hub.links.network.cuts.absent import Absent
from canwire.hub.links.network.cuts.broken import Breaks
from canwire.hub.links.network.offered import GRACE_S
from canwire.hub.links.network.pump import Pump
from canwire.hub.links.network.session.settings import CUT_S, LEASE_S, Patience
from tests.cases import each

pytestmark = [pytest.mark.conforms("N-30"), pytest.mark.finding("machines 3")]
_S = 1_000_000_000
_STEP_S = 0.5  # of the model; signs of life come as often
_BACK_S = 4.0  # a new connection, at the latest so long after the cut: a system's third attempt ...
_WORD_S = 3.0  # ... and the first word on it, as was measured


class End:
    """One of the two: when it heard the other one, and how long that one has heard nothing."""

    def __init__(self) -> None:
        self.heard_s = 0.0
        self.unheard_s = 0.0

    def hear(self, now_s: float, other: End) -> None:
        self.heard_s, self.unheard_s = now_s, now_s - other.heard_s

    def silent_ns(self, now_s: float) -> int:
        return round(max(now_s - self.heard_s, self.unheard_s) * _S)


class Bench:
    """A hub and a client, the way between them cut from 1 s on for so long, up, down or both ways."""

    def __init__(self, cut_s: float, up: bool, down: bool) -> None:
        self.up, self.down = up, down
        self.mended_s = 1 + cut_s
        self.hub, self.client = End(), End()
        self.breaks, self.absent = Breaks(Patience()), Absent(LEASE_S, GRACE_S, CUT_S)
        self.connected = True

    def play(self) -> str:
        """Who gave up; "" for nobody."""
        for step in range(int((self.mended_s + _BACK_S + _WORD_S + 1) / _STEP_S) + 1):
            now_s = step * _STEP_S
            if self.connected:
                self.exchange(now_s)
            elif now_s >= self.mended_s + _BACK_S:
                self.come_back(now_s)
            due_ns = self.breaks.due_ns(round(self.client.heard_s * _S))
            if due_ns is not None and now_s * _S >= due_ns:
                return f"the client at {now_s} s"
            if self.absent.over(now_s):
                return f"the hub at {now_s} s"
        assert not self.absent
        return ""

    def exchange(self, now_s: float) -> None:
        """Signs of life, where there is a way; and the connection is given up by who hears nothing for a lease."""
        cut = 1 < now_s < self.mended_s
        if not (cut and self.up):
            self.hub.hear(now_s, self.client)
        if not (cut and self.down):
            self.client.hear(now_s, self.hub)
        if max(now_s - self.hub.heard_s, now_s - self.client.heard_s) >= LEASE_S:
            self.connected = False
            self.absent.went("client", now_s, self.hub.silent_ns(now_s))
            for _ in ("its transport", "the hub's token"):
                heard_ns = round(self.client.heard_s * _S)
                self.breaks.gone(round(now_s * _S), heard_ns, self.client.silent_ns(now_s))

    def come_back(self, now_s: float) -> None:
        if now_s == self.mended_s + _BACK_S:
            self.breaks.back(round(now_s * _S))
            self.absent.came("client")
        if now_s >= self.mended_s + _BACK_S + _WORD_S:
            self.client.heard_s = self.hub.heard_s = now_s


@each(("up", "down"), [(True, True), (True, False), (False, True)])
def test_no_cut_of_up_to_30_s_ends_a_connection(up: bool, down: bool) -> None:
    gave_up = {cut_s: who for cut_s in range(1, 31) if (who := Bench(cut_s, up, down).play())}
    assert gave_up == {}


def test_who_is_away_for_longer_is_given_up_at_both_ends() -> None:
    bench = Bench(100, True, True)
    assert bench.play() == f"the client at {1 + LEASE_S + CUT_S} s"
    assert bench.absent.over(1 + LEASE_S + CUT_S) == ["client"]


def test_a_connection_that_is_closed_is_borne_for_less_than_two_seconds() -> None:
    breaks = Breaks(Patience())
    breaks.gone(10 * _S, 10 * _S, 0)
    assert breaks.due_ns(10 * _S) == 11.5 * _S
    breaks.back(11 * _S)  # a switch was restarted: the hub may be heard of a moment later
    assert breaks.due_ns(10 * _S) == 16 * _S
    assert breaks.due_ns(12 * _S) is None
    breaks.gone(20 * _S, 20 * _S, 0)  # and that is forgotten the next time
    assert breaks.due_ns(20 * _S) == 21.5 * _S


def test_each_end_says_how_long_it_has_heard_nothing() -> None:
    said: list[bytes] = []
    deaf, other = Pump(said.append), Pump(lambda payload: None)
    try:
        deaf.heard_ns -= 8 * _S
        deaf._turn()
        for payload in said:
            other.take(payload)
        assert wire.states_in(said[0])[0][0] == wire.SILENCE
        assert 8 * _S <= other.silent_ns < 60 * _S
    finally:
        deaf.close()
        other.close()
