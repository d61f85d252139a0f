"""Verbs, each as a process of Windows, on a hub there."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tests.windows.conftest import Windows, line_of

pytestmark = pytest.mark.conforms("N-64")

EXAMPLES = Path(__file__).parent.parent.parent / "examples"
DBC, LOG = (Windows.path(EXAMPLES / name) for name in ("engine.dbc", "car-candump.log"))
BEGINS = "HW000001:0"
WITHOUT_A_HUB = {  # words, and what they say
    "--version": "uncompiled",
    "bits 123#1122": "62 bits from SOF",
    "timing 500000": "sample point 87.50%",
    f"db {DBC}": "EngineData",
    f"stats {LOG}": "12974 frames",
    f"decode --db {DBC} {LOG}": "",
    "demo": "bus time      30.000000 s",
    "campaign --help": "--results FILE",
    "acan --help": "canwire acan",
    "run python": "Linux",
    "adapters": "canwire: serial ports cannot be listed here",  # on Wine, which lacks what pyserial asks for
    "share": "canwire: serial ports cannot be listed here",
    f"convert {LOG} C:\\canwire.asc": "12974 entries from candump to asc",
    "native vcinpl2 --cflags": "canwire\\native\\include",
    "completion bash": "complete",
    "slcan": "Windows has no pseudo terminals; use --tcp",
    "devices --hub C:\\nowhere\\hub": "no hub listens on C:",
}
HELP_ALONE = [  # of verbs that need another hub, an ECU, a terminal, or packages that this Python does not have
    *("bridge", "candrv", "detect", "isotp", "pace", "plot"),
    *("query", "router", "simulate", "socketcand", "uds", "view"),
]
ALL_HELP = f"""
from canwire.commands import main
for verb in {HELP_ALONE}:
    try:
        main([verb, "--help"])
    except SystemExit as end:
        assert not end.code, verb
"""
ON_A_HUB = {  # in this order
    "doctor": "Windows 10",
    "plug usb-to-can": "HW000005",
    "devices": "HW000005",
    "up HW000002:0": "500000 bit/s",
    f"gen {BEGINS} --count 5": "5 sent",
    f"lin dump {BEGINS}": "canwire:",
    "load --count 1": "can0",
    "registers HW000002": "an ideal controller, without registers",
    "fault can0 flip --id 7FF --bit 20 --stay": "",
    "fault can0 --list": "flip",
    "fault can0 --clear": "",
    f"play {LOG} {BEGINS} --speed 0 --filter 7E2": "9",
    "recover HW000002:0": "not bus-off",
    "stop HW000002:0": "stopped",
    "unplug HW000005": "",
}


def test_verbs_without_a_hub(windows: Windows) -> None:
    with ThreadPoolExecutor(2) as pool:
        said = dict(
            zip(
                WITHOUT_A_HUB,
                pool.map(lambda each: windows.canwire(*each.split()), WITHOUT_A_HUB),
                strict=True,
            )
        )
    assert unexpected(said, WITHOUT_A_HUB) == {}


def test_help_of_the_other_verbs(windows: Windows) -> None:
    said = windows.run("-c", ALL_HELP)
    assert [verb for verb in HELP_ALONE if f"usage: canwire {verb}" not in said] == [], said
    assert "Traceback" not in said


def test_verbs_on_a_hub(windows: Windows, hub: str) -> None:
    said = {words: windows.canwire(*words.split(), "--hub", hub) for words in ON_A_HUB}
    assert unexpected(said, ON_A_HUB) == {}


def unexpected(said: dict[str, str], expected: dict[str, str]) -> dict[str, str]:
    """What said something else than it should, or broke down."""
    return {words: text for words, text in said.items() if expected[words] not in text or "Traceback" in text}


def test_what_one_sends_another_shows(windows: Windows, hub: str) -> None:
    windows.done("up", "HW000002:0", "--hub", hub)
    dump = windows.start("-m", "canwire", "dump", "HW000002:0", "--hub", hub, "--count", "1")
    while dump.poll() is None:  # it listens as soon as it has begun, of which it says nothing
        windows.canwire("send", BEGINS, "123#1122", "--hub", hub)
    assert "11 22" in line_of(dump, "123")
