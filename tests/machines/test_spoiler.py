"""The network between machines that tests make: what arrives, when, and what never does."""

from __future__ import annotations

import random
import subprocess

import pytest

from tests.machines.namespaces import machines, why_not
from tests.machines.spoiler import Way


def test_a_rate_is_kept_and_what_waits_too_long_is_dropped() -> None:
    way, dice = Way(rate=1000, queue=2000), random.Random(0)
    assert [way.due_s(10.0, 1000, dice) for _ in range(5)] == [11.0, 12.0, 13.0, None, None]
    assert way.due_s(12.5, 1000, dice) == 14.0
    assert (way.passed, way.dropped) == (4, 2)


def test_cut_lossy_and_slow_ways() -> None:
    dice = random.Random(1)
    assert Way(cut=True).due_s(1.0, 10, dice) is None
    assert Way(delay_s=0.5).due_s(1.0, 10, dice) == 1.5
    lossy = Way(loss=0.25)
    lost = sum(lossy.due_s(1.0, 10, dice) is None for _ in range(1000))
    assert 200 < lost < 300


@pytest.mark.skipif(bool(why_not()), reason=why_not())
def test_two_machines_hear_each_other_unless_the_way_is_cut() -> None:
    listen = "import socket; s = socket.create_server(('10.77.0.1', 7)); print(1, flush=True)"
    listen += "; print(s.accept()[0].recv(9))"
    speak = (
        "import socket, sys; socket.create_connection(('10.77.0.1', 7), float(sys.argv[1])).send(b'hello')"
    )
    with machines(2) as (both, spoiler):
        one, other = both
        python = ["python3", "-S", "-c"]
        with subprocess.Popen(one.words([*python, listen]), stdout=subprocess.PIPE, text=True) as listener:
            assert listener.stdout is not None
            assert listener.stdout.readline() == "1\n"
            spoiler.ways[1, 0].cut = True
            tried = subprocess.run(other.words([*python, speak, "0.1"]), capture_output=True, text=True)
            assert "TimeoutError" in tried.stderr
            assert spoiler.ways[1, 0].passed == 0
            assert spoiler.ways[1, 0].dropped > 0
            spoiler.heal()
            subprocess.run(other.words([*python, speak, "60"]), check=True)
            assert listener.stdout.readline() == "b'hello'\n"
