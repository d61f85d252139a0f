"""Programs in processes of their own on one machine, and the death of hub and programs."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

import canwire
from canwire import Frame, HubLost
from canwire.acan import api
from canwire.acan.constants import Action
from canwire.acan.driver import open_driver
from canwire.acan.filters import Filter
from canwire.acan.hard_config import HardConfig
from canwire.acan.install import DriverAbsent
from canwire.acan.task_block import TaskBlock
from tests import warm
from tests.hubs import Served

LONG = 30  # seconds after which something that should happen never will
PROGRAM = """
import sys
import canwire
from canwire.acan.constants import Action
from canwire.acan.driver import open_driver
from canwire.acan.filters import Filter
from canwire.acan.hard_config import HardConfig
from canwire.acan.task_block import TaskBlock

with canwire.connect(sys.argv[1]) as hub, open_driver(hub) as driver:
    {body}
"""


@pytest.fixture
def program() -> Iterator[Callable[[str, str], subprocess.Popen[str]]]:
    """Other programs; a body runs with a driver at this address and says "ready" first."""
    started: list[subprocess.Popen[str]] = []

    def start(address: str, body: str) -> subprocess.Popen[str]:
        words = [sys.executable, "-c", PROGRAM.format(body=body.replace("\n", "\n    ")), address]
        process = warm.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        started.append(process)
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()


def ended(process: subprocess.Popen[str]) -> str:
    """What it said until its end."""
    said, _ = process.communicate("", LONG)
    assert process.returncode == 0
    return said


RECEIVER = """
block = driver.register(TaskBlock([Filter.any()]))
print("ready", flush=True)
for frame in block:
    print(frame.id, frame.data.decode(), flush=True)
    if frame.data == b"end":
        break
"""


@pytest.mark.conforms("AC-21", "AC-32")
def test_programs_of_one_machine_hear_the_bus_and_each_other(mortal_hub: Served, program: Any) -> None:
    address, _ = mortal_hub
    with canwire.connect(address) as hub, open_driver(hub) as driver:
        driver.configure(HardConfig())
        driver.bus_on()
        receivers = [program(address, RECEIVER) for _ in range(2)]
        driver.send(Frame(1, b"quiet"), 1)
        driver.send(Frame(2, b"loud"), 0)
        driver.send(Frame(3, b"end"), 0)
        assert [ended(receiver) for receiver in receivers] == ["2 loud\n3 end\n"] * 2


@pytest.mark.conforms("AC-24")
def test_a_program_that_does_nothing_answers_through_its_channel(mortal_hub: Served, program: Any) -> None:
    address, _ = mortal_hub
    body = """
variable = bytearray(b"state")
driver.register(TaskBlock([Filter.one(0x20, actions=Action.CHANSND, variable=variable)]))
print("ready", flush=True)
sys.stdin.read()
"""
    with canwire.connect(address) as hub, open_driver(hub) as driver:
        driver.configure(HardConfig())
        driver.bus_on()
        answering = program(address, body)
        variable = bytearray(8)
        channel = Filter.one(0x21, actions=Action.CHANRCV | Action.NOTIFY, variable=variable)
        with driver.register(TaskBlock([channel])) as block:
            driver.send(Frame(0x20, (0x21 << 18).to_bytes(4, "little") + bytes([0, 8])), 0)
            assert block.wait(LONG)
            assert variable == b"state\0\0\0"
        ended(answering)


@pytest.mark.conforms("AC-14", "AC-35")
@pytest.mark.conforms("N-04")
def test_a_program_that_dies_leaves_the_line_set_up_and_nothing_behind(
    mortal_hub: Served, program: Any
) -> None:
    address, _ = mortal_hub
    body = """
driver.configure(HardConfig(rate_kbps=125))
driver.bus_on()
driver.register(TaskBlock([Filter.any()]))
print("ready", flush=True)
sys.stdin.read()
"""
    with canwire.connect(address) as hub:
        dying = program(address, body)
        dying.kill()
        dying.communicate(timeout=LONG)
        with open_driver(hub) as driver:
            assert not driver.on_bus
            assert driver.config() == HardConfig(rate_kbps=125)
            driver.configure(HardConfig())


def test_waits_end_when_the_hub_dies(mortal_hub: Served) -> None:
    address, process = mortal_hub
    with canwire.connect(address) as hub, open_driver(hub) as driver:
        block = driver.register(TaskBlock([Filter.any()]))
        failures: list[BaseException] = []

        def iterate() -> None:
            try:
                list(block)
            except HubLost as error:
                failures.append(error)

        threads = [threading.Thread(target=iterate) for _ in range(2)]
        for thread in threads:
            thread.start()
        process.kill()
        for thread in threads:
            thread.join(LONG)
        assert len(failures) == 2
        with pytest.raises(HubLost):
            block.wait(LONG)
        with pytest.raises(HubLost):
            driver.send(Frame(1))


@pytest.mark.conforms("AC-09")
def test_functions_answer_failure_once_the_hub_is_gone(mortal_hub: Served) -> None:
    address, process = mortal_hub
    with canwire.connect(address) as hub:
        api.use(hub)
        assert api.ACAN_Init() == 0x0100
        process.kill()
        process.wait(LONG)
        assert api.ACAN_BusControl(1) == 0
        assert api.ACAN_GetInitStatus() == 0
        assert api.ACAN_GetDriverVersion() == 0
        assert api.ACAN_Init() == 0
        assert isinstance(api.last_error(), HubLost)
        api.use(None)


@pytest.mark.conforms("AC-09")
def test_without_a_hub_the_usual_one_is_used_and_left_again(
    mortal_hub: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CANWIRE_HUB", mortal_hub[0])
    with canwire.connect() as hub:
        board = hub.board("inducan104").id
        with open_driver() as driver:
            assert not driver.initialised
            assert hub.line_status(board, 0).channels == 1
        assert hub.line_status(board, 0).channels == 0
        assert driver.hub.lost
        api.use(None)
        assert api.ACAN_Init() == 0x0100
        assert hub.line_status(board, 0).channels == 1
        api.ACAN_Exit()
        hub.set_note("acan", b"uninstalled")
        with pytest.raises(DriverAbsent):
            open_driver()
