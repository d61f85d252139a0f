"""Compiled or interpreted: known, as expected, and the same to the last byte."""

from __future__ import annotations

import hashlib
import os
import random
from types import ModuleType

import pytest

import canwire
from canwire import core
from tests.uncompiled import load_uncompiled

pytestmark = pytest.mark.core

FD_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)


@pytest.mark.skipif("CANWIRE_EXPECT" not in os.environ, reason="CANWIRE_EXPECT does not say what is expected")
def test_runs_in_the_form_that_was_asked_for() -> None:
    assert canwire.core_mode() == os.environ["CANWIRE_EXPECT"]


def test_the_core_is_never_half_compiled() -> None:
    assert canwire.core_mode() in ("compiled", "uncompiled")


@pytest.mark.smoke
def test_the_twin_is_another_copy_and_interpreted() -> None:
    mode, frame = canwire.core_mode(), canwire.Frame
    with load_uncompiled(canwire) as twin:
        assert twin is not canwire
        assert twin.Frame is not frame
        assert twin.core_mode() == "uncompiled"
        assert twin.Frame.__init__.__class__.__name__ == "function"  # a Python function, no C slot
    assert (canwire.core_mode(), canwire.Frame) == (mode, frame)
    if mode == "compiled":
        assert all(not str(module.__file__).endswith(".py") for module in core.MODULES)
        assert frame.__init__.__class__.__name__ != "function"


@pytest.mark.conforms("G-17")
def test_both_forms_do_the_same() -> None:
    here = {seed: traffic(canwire, seed) for seed in range(4)}
    with load_uncompiled(canwire) as twin:
        assert {seed: traffic(twin, seed) for seed in here} == here


def test_both_forms_do_the_same_on_lin() -> None:
    here = {seed: lin_traffic(canwire, seed) for seed in range(4)}
    assert len(set(map(str, here.values()))) == 4
    with load_uncompiled(canwire) as twin:
        assert {seed: lin_traffic(twin, seed) for seed in here} == here


@pytest.mark.smoke
def test_other_seeds_do_something_else() -> None:
    assert traffic(canwire, 1)["all"] != traffic(canwire, 2)["all"]


def traffic(package: ModuleType, seed: int) -> dict[str, object]:
    """Random frames of six nodes with noise and scripted faults: what everybody saw, hashed."""
    chance = random.Random(seed)
    with package.Lab(seed=seed) as lab:
        bus = lab.can_bus(bit_rate=500_000, data_bit_rate=2_000_000, iso_fd=bool(seed % 2))
        nodes = [
            bus.node("everything"),
            bus.node("filtered", filters=[(0x100, 0x700), (0x100, 0x1FFFFF00, True)]),
            bus.node("own too", self_reception=True, options=late_options(package)),
            bus.node("small", receive_queue=16),
            bus.node("silent", listen_only=True),
            bus.node("quiet", options=package.ControllerOptions(restricted=True, edge_filter=True)),
        ]
        for node in nodes:
            node.events()
        bus.faults.noise(1e-3)
        bus.faults.flip(frame_id=0x123, bit=20, times=2)
        bus.faults.flip(bit="crc delimiter", times=1, seen_by=nodes[1])
        for _ in range(300):
            sender = nodes[chance.randrange(4)]
            sender.send(
                random_frame(package, chance),
                single_shot=chance.random() < 0.1,
                high_priority=chance.random() < 0.1,
                delay_ns=chance.choice([0, 0, 0, 700_000]),
            )
            if chance.random() < 0.3:
                lab.run_for(chance.uniform(0, 0.002))
        lab.run_for(2.0)
        return summary(lab, bus, nodes)


def lin_traffic(package: ModuleType, seed: int) -> list[object]:
    """A LIN bus with a schedule, faults, changed responses, nodes that leave, sleep: what everybody saw."""
    chance = random.Random(seed)
    with package.Lab(seed=seed) as lab:
        bus = lab.lin_bus(bit_rate=19_200)
        bus.remember(1000)
        master = bus.master(schedule=[0x10, 0x11, 0x20, 0x3C, 0x21], receive_queue=64)
        slaves = [
            bus.slave("doors", responses={0x10: b"12", 0x11: bytes(8)}, subscribes={0x20: 4}),
            bus.slave("seats", responses={0x20: b"1234"}, oscillator_ppm=20_000, self_reception=True),
        ]
        for node in (master, *slaves):
            node.events()
        bus.faults.checksum(0x11)
        bus.faults.no_response(0x20, times=3)
        bus.faults.parity(times=2)
        for step in range(40):
            slave = chance.choice(slaves)
            slave.respond(chance.choice([0x10, 0x11, 0x20]), chance.randbytes(chance.randrange(1, 9)))
            if chance.random() < 0.2:
                slave.stop()
            elif chance.random() < 0.5:
                slave.start()
            if step % 10 == 9:
                master.sleep()
                lab.run_for(0.05)
                master.wake()
            lab.run_for(chance.uniform(0, 0.1))
        everybody = [master, *slaves]
        told = [(str(node.counters), str(node.events()), str(node.receive_many(100))) for node in everybody]
        return [lab.now_ns, bus.frames, bus.load, str(bus.recent()), *told]


def late_options(package: ModuleType) -> object:
    """A sender that reads itself later than its sample point, and knows it."""
    return package.ControllerOptions(450, package.DelayCompensation(300, filter_ns=500))


def summary(lab: object, bus: object, nodes: list[object]) -> dict[str, object]:
    """A hash of every record, event and counter, beside some of them for whoever reads the difference."""
    whole = hashlib.sha256()
    told: dict[str, object] = {"now": lab.now_ns, "frames": bus.frames, "errors": bus.error_frames}  # type: ignore[attr-defined]
    told["load"] = (bus.load, bus.mean_load, bus.peak_load)  # type: ignore[attr-defined]
    for node in nodes:
        records = node.receive_array().tobytes()  # type: ignore[attr-defined]
        events = b"".join(event.to_record() for event in node.events())  # type: ignore[attr-defined]
        counts = [str(node.counters)]  # type: ignore[attr-defined]
        for name in (
            "accepted",
            "waiting",
            "lost",
            "sent",
            "delivered",
            "aborted",
            "pending",
            "arbitration_losses",
        ):
            counts.append(f"{name} {getattr(node, name)}")
        told[node.name] = (counts, len(records) // 80, len(events) // 80)  # type: ignore[attr-defined]
        whole.update(records + events)
    whole.update(repr(told).encode())
    return told | {"all": whole.hexdigest()}


def random_frame(package: ModuleType, chance: random.Random) -> object:
    extended = chance.random() < 0.4
    id = chance.choice([0x100, 0x101, 0x123, 0x1FF, chance.getrandbits(29 if extended else 11)])
    kind = chance.random()
    if kind < 0.1:
        return package.Frame(id, extended=extended, remote=True, dlc=chance.randrange(9))
    if kind < 0.4:
        data = chance.randbytes(chance.choice(FD_LENGTHS))
        switch = chance.random() < 0.7
        return package.Frame(id, data, extended=extended, fd=True, bit_rate_switch=switch)
    return package.Frame(id, chance.randbytes(chance.randrange(9)), extended=extended)
