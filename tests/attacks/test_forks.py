"""A fork with all kinds of things open: in the child each is the child's own, or says that it is the parent's."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from tests import warm
from tests.hubs import LONG_S

pytestmark = [
    pytest.mark.skipif(sys.platform == "win32", reason="nothing forks there"),
    pytest.mark.finding("faults-2 2"),
]

FORKED = "belongs to the process that was forked"
BEGIN = """
import gc, json, os, sys
from canwire import *
from canwire.ring import Ring
home = sys.argv[1]

def said(call):
    try:
        return call()
    except CanwireError as error:
        return str(error)

def in_child(look):
    read, write = os.pipe()
    if not os.fork():
        os.write(write, json.dumps(look(), default=str).encode())
        os._exit(0)
    os.close(write)
    with open(read) as file:
        told = json.load(file)
    os.wait()
    return told
"""


def ran(script: str, home: Path) -> object:
    words = [sys.executable, "-c", BEGIN + script, str(home)]
    done = warm.run(words, capture_output=True, text=True, timeout=LONG_S)
    assert (done.stderr, done.returncode) == ("", 0)
    return json.loads(done.stdout)


def test_a_lab_in_virtual_time_and_a_ring_are_the_childs_own(tmp_path: Path) -> None:
    script = """
lab = Lab()
bus = lab.can_bus()
a, b = bus.node("a"), bus.node("b")
ring = Ring(4)
ring.put_bytes(bytes(80))
a.send(Frame(1))
lab.run_until_idle()
def look():
    a.send(Frame(2))
    lab.run_until_idle()
    return [frame.id for frame in b.receive_many(9)], len(ring.take_frames(9))
child = in_child(look)
a.send(Frame(3))
lab.run_until_idle()
print(json.dumps([child, [[frame.id for frame in b.receive_many(9)], len(ring.take_frames(9))]]))
"""
    assert ran(script, tmp_path) == [[[1, 2], 1], [[1, 3], 1]]


def test_a_lab_in_real_time_says_whose_it_is(tmp_path: Path) -> None:
    script = """
with Lab(time="real") as lab:
    bus = lab.can_bus()
    a, b = bus.node("a"), bus.node("b")
    lab.hub()
    def look():
        calls = [lambda: lab.can_bus("other"), lambda: a.send(Frame(1)), lambda: b.receive(timeout=1),
                 lambda: lab.run_for(1), lab.run_until_idle, lambda: lab.serve(home + "/hub"), lab.hub]
        return [said(call) for call in calls], lab.close()
    child = in_child(look)
    a.send(Frame(1))
    print(json.dumps([child, b.receive(timeout=60).id]))
"""
    (told, closed), here = ran(script, tmp_path)  # type: ignore[misc]
    assert all(FORKED in text for text in told)
    assert (len(told), closed, here) == (7, None, 1)


def test_what_is_written_is_the_parents(tmp_path: Path) -> None:
    """Logs of every kind, packed ones too, a recording, a trace of levels: not a byte comes from the child."""
    script = """
names = "a.log b.asc c.blf d.mf4 e.parquet f.pcapng g.csv h.trc i.db j.journal k.log.gz l.trace".split()
entry = LogEntry(5, "can0", Frame(1), "R")
logs = [create_log(f"{home}/{name}") for name in names]
for log in logs:
    log.write(entry)
lab = Lab()
bus = lab.can_bus()
a, b = bus.node("a"), bus.node("b")
recorder = record(b, f"{home}/recorded.log")
bus.trace_levels(f"{home}/levels.vcd")
a.send(Frame(1))
lab.run_for(0.1)
def look():
    told = [said(lambda: log.write(entry)) for log in logs]
    for log in logs:
        log.close()
    logs.clear()
    a.send(Frame(2))
    told.append(said(lambda: lab.run_for(0.1)))
    bus.end_trace()
    lab.run_for(0.1)
    told.append(said(recorder.close))
    gc.collect()
    return told
child = in_child(look)
for log in logs:
    log.write(entry)
    log.close()
recorder.close()
bus.end_trace()
counts = [len(list(open_log(f"{home}/{name}"))) for name in names]
frames = [one.content.id for one in open_log(f"{home}/recorded.log") if isinstance(one.content, Frame)]
print(json.dumps([child, counts, frames, open(f"{home}/levels.vcd").read().count("$enddefinitions")]))
"""
    told, counts, frames, heads = ran(script, tmp_path)  # type: ignore[misc]
    assert [FORKED in (text or "") for text in told] == [True] * 14
    assert counts == [2] * 12
    assert (frames, heads) == ([1], 1)


def test_both_read_a_log_to_its_end(tmp_path: Path) -> None:
    script = """
with create_log(f"{home}/long.log") as log:
    log.write_many(LogEntry(n * 1000, "can0", Frame(n % 2048)) for n in range(20_000))
with open_log(f"{home}/long.log") as log:
    entries = iter(log)
    next(entries)
    child = in_child(lambda: sum(1 for _ in entries))
    print(json.dumps([child, sum(1 for _ in entries)]))
"""
    assert ran(script, tmp_path) == [19_999, 19_999]


@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
def test_workers_beside_everything_that_is_open(tmp_path: Path, method: str) -> None:
    script = f"""
import multiprocessing
from tests.attacks.workers import number_of
if __name__ == "__main__":
    lab, real, hub = Lab(), Lab(time="real"), connect(time="real")
    node = lab.can_bus().node("a")
    real.can_bus().node("b")
    log, reader = create_log(f"{{home}}/a.log"), SlcanReader()
    with multiprocessing.get_context({method!r}).Pool(1) as pool:
        found = pool.map(number_of, range(3), chunksize=1)
        try:
            pool.apply(number_of, (lab,))
        except TypeError as error:
            found.append("cannot pickle" in str(error))
    log.write(LogEntry(1, "can0", Frame(1)))
    log.close()
    real.close()
    found.append(len(hub.boards()) > 0)
    print(json.dumps(found))
"""
    assert ran(script, tmp_path) == [0, 1, 2, True, True]
