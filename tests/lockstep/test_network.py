"""Programs on other machines that keep one time: docs/time.md's five over the network, and what becomes of cut ones."""

from __future__ import annotations

import os
import signal
from contextlib import closing
from pathlib import Path

import pytest

from canwire.platform import PORTABLE
from tests.hub.links.network.places import Cable
from tests.hubs import LONG_S
from tests.lockstep.programs import bench, five_programs, page_serves
from tests.lockstep.test_ends import ENDLESS, KILLED, LOSES, STEPS, devices, first_line
from tests.lockstep.test_repeated import PROGRAM

pytest.importorskip("can")
pytest.importorskip("zenoh")

from tests.threads.apart import played_apart
from tests.threads.shapes import SHAPES
from tests.threads.test_shapes import in_a_hub

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.skipif(PORTABLE, reason="hubs of other machines need Linux' own platform"),
]
RUNS = int(os.environ.get("CANWIRE_LOCKSTEP_RUNS", "1"))
FIVE = tuple(five_programs())


def heard(home: Path, remote: tuple[str, ...]) -> str:
    with bench(home, *page_serves()) as made:
        made.offered(remote)
        return made.run(five_programs(), "1")["log"]


@pytest.mark.long
@pytest.mark.conforms("G-17", "PL-01", "PL-11")
def test_five_dialects_over_the_network_give_the_same_log_every_time(tmp_path: Path) -> None:
    first = heard(tmp_path / "mixed", FIVE[::2])
    assert {line.split()[1].partition("#")[0] for line in first.splitlines()} >= {
        "101", "102", "103", "111", "112", "120", "7DF"
    }  # fmt: skip
    for number in range(RUNS):
        assert heard(tmp_path / str(number), FIVE) == first


@pytest.mark.conforms("G-17", "N-35")
def test_random_programs_do_on_the_network_what_they_do_beside_the_hub(tmp_path: Path) -> None:
    found = []
    for number, remote in enumerate([(), ("p0", "p2"), ("p0", "p1", "p2")]):
        with bench(tmp_path / str(number), "--programs", "3", "--patience", "60") as made:
            made.offered(remote)
            words = {f"p{n}": (str(n), "7", "100000000") for n in range(3)}
            found.append(made.run(dict.fromkeys(words, PROGRAM), own_words=words, timeout_s=4 * LONG_S))
    assert min(text.count("\n") for text in found[0].values()) > 1
    for remotely in found[1:]:
        for name, beside in found[0].items():
            assert remotely[name].splitlines() == beside.splitlines(), name
        assert remotely == found[0]


@pytest.mark.conforms("G-17")
@pytest.mark.finding("machines 4")
@pytest.mark.parametrize("name", SHAPES)
def test_programs_with_threads_give_the_log_that_they_give_in_one_process(name: str, tmp_path: Path) -> None:
    *log, _ = in_a_hub(name)
    assert played_apart(tmp_path, name, name, ("ecu1", "ecu2", "tester")) == log


def test_a_killed_one_is_let_go_with_a_word(tmp_path: Path) -> None:
    with bench(tmp_path, "--programs", "a,b") as made:
        made.offered(("b",))
        steps, killed = made.start("a", STEPS), made.start("b", KILLED)
        assert killed.wait(LONG_S) == -signal.SIGKILL
        assert [first_line(steps), first_line(steps)] == ["ready", "1000000000"]
        word = made.hears("b (")
        assert word.startswith(f"canwire: b ({killed.pid} on ")
        assert word.endswith(" has left at 0.055000000 s: time continues without it")


COMPUTES = """
import canwire, signal
with canwire.connect() as hub:
    hub.sleep(0.010)
    print("ready", flush=True)
    signal.pause()  # which the hub knows nothing of
"""


def test_one_that_computes_is_named_with_its_machine(tmp_path: Path) -> None:
    with bench(tmp_path, "--programs", "2", "--patience", "0.3") as made:
        made.offered(("a",))
        busy, other = made.start("a", COMPUTES), made.start("b", ENDLESS)
        assert [first_line(busy), first_line(other)] == ["ready", "ready"]
        said = made.hears(f"time stopped at 0.010000000 s: a ({busy.pid} on ")  # a slow start is named, too
        assert "thread 0, computes" in said
        assert f"canwire: {devices(made)['standstill']}" == said


IN_C = """
import canwire, ctypes
with canwire.connect() as hub:
    hub.sleep(0.010)
    print("ready", flush=True)
    ctypes.PyDLL(None).usleep(SPAN_US)  # with the interpreter's lock: nothing else of this process's Python runs
    hub.sleep(0.010)
    print(hub.now_ns(), flush=True)
"""


@pytest.mark.finding("machines 13")
def test_a_long_call_in_c_loses_nobody_its_place(tmp_path: Path) -> None:
    """It was lost after 1.6 s; only its patience ends, as beside the hub."""
    with bench(tmp_path, "--programs", "a,b", "--patience", "0.5") as made:
        made.offered(("a",))
        busy, other = made.start("a", IN_C.replace("SPAN_US", "2_200_000")), made.start("b", ENDLESS)
        assert [first_line(busy), first_line(other)] == ["ready", "ready"]
        made.hears(f"time stopped at 0.010000000 s: a ({busy.pid} on ")
        assert first_line(busy) == "20000000"


CUT = """
import canwire, os
from canwire.hub.links.network.client import NetworkLink
from canwire.hub.links.network.session.settings import Patience
with canwire.Hub(NetworkLink(os.environ["CANWIRE_HUB"], "b", patience=Patience(timed_s=1.6))) as hub:
    hub.keep_time("b")
    print("ready", flush=True)
    try:
        while True:
            hub.sleep(0.010)
    except canwire.HubLost as error:
        print(error, flush=True)
"""


def test_one_whose_cable_is_cut_is_let_go_and_hears_of_it(tmp_path: Path) -> None:
    with bench(tmp_path, "--programs", "a,b") as made:
        made.offered(("b",), "--silence", "1.6")
        base, _, port = made.network.rpartition(":")
        with closing(Cable(int(port))) as cable:
            made.network = f"{base}:{cable.port}"
            endless, cut = made.start("a", ENDLESS), made.start("b", CUT)
            assert [first_line(endless), first_line(cut)] == ["ready", "ready"]
            cable.cut()
            assert "no message from" in first_line(cut)
            assert f"b ({cut.pid} on " in made.hears("has left at")


@pytest.mark.parametrize("which", ["hub", "offer"])
def test_one_that_waits_for_its_turn_hears_that_the_hub_is_gone(which: str, tmp_path: Path) -> None:
    with bench(tmp_path, "--programs", "1") as made:
        offer = made.offered(("waits",))
        waits = made.start("waits", LOSES)
        assert first_line(waits) == "ready"
        if which == "hub":
            made.kill_hub()
        else:
            offer.kill()
        assert first_line(waits) == "lost"
        assert waits.wait(LONG_S) == 0
