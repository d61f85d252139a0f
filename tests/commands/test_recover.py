"""`canwire recover`: a line begins again after bus-off, whoever configured it."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterator
from typing import Any

import pytest

from canwire import BadValue, ErrorState
from canwire.commands import main
from canwire.commands import recover as recover_module
from tests.together.players.player import DONE
from tests.together.players.vci_v4 import VciV4
from tests.together.scene import BOARD, Scene, virtual_scene


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> Iterator[Scene]:
    """A VCI program that holds the control of its line."""
    with virtual_scene("usb-to-can-fd") as made:
        monkeypatch.setattr(recover_module, "connected", lambda *_: made.connect("canwire recover"))
        yield made


def _recover(line: str) -> int:
    return recover_module.run(Namespace(line=line, hub=None))


@pytest.mark.smoke
@pytest.mark.parametrize("name", [f"{BOARD}:0", "can0"])
@pytest.mark.conforms("N-02")
def test_a_line_begins_again_whoever_holds_its_control(
    scene: Scene, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    program: Any = scene.play(VciV4)
    assert program.set_up() == DONE
    scene.bus_off()
    assert scene.status().state == ErrorState.BUS_OFF
    assert _recover(name) == 0
    shown = capsys.readouterr()
    assert shown.out.startswith(f"{BOARD}:0: error active, 250000 bit/s, 2000000 after BRS, set by vci v4 (")
    assert shown.err == ""
    assert scene.status().control_holder.startswith("vci v4 (")
    assert scene.hear(program)


def test_a_line_that_is_not_bus_off_is_left_alone(scene: Scene, capsys: pytest.CaptureFixture[str]) -> None:
    program = scene.play(VciV4)
    assert program.set_up() == DONE
    assert _recover(f"{BOARD}:0") == 1
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.startswith(
        f"canwire: {BOARD}:0 is not bus-off: error active, 250000 bit/s, 2000000 after BRS, "
    )
    assert scene.hear(program)


def test_a_line_that_nobody_set_up(scene: Scene, capsys: pytest.CaptureFixture[str]) -> None:
    assert _recover(f"{BOARD}:0") == 1
    assert capsys.readouterr().err == f"canwire: {BOARD}:0 is not bus-off: not initialised\n"


def test_lin_lines_know_no_bus_off(scene: Scene) -> None:
    with pytest.raises(BadValue, match=f"{BOARD}:2: {BOARD}:2 is a LIN line, which knows no bus-off"):
        _recover(f"{BOARD}:2")


def test_without_a_hub_there_is_nothing_to_recover(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Any
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("CANWIRE_HUB", raising=False)
    assert main(["recover", "can0"]) == 2
    assert (
        "no hub is running that `recover` could share; `canwire serve` starts one" in capsys.readouterr().err
    )
