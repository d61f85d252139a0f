"""docs/fd-controllers.md: its examples run, and its options are those there are."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path
from typing import Any

from canwire import ControllerOptions
from canwire.boards.config.configuration import Config

TEXT = (Path(__file__).parents[2] / "docs" / "fd-controllers.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", TEXT, re.DOTALL | re.MULTILINE)


def test_the_examples_run() -> None:
    names: dict[str, Any] = {}
    examples = blocks("python")
    assert len(examples) == 3
    for example in examples:
        exec(compile(example, "fd-controllers.md", "exec"), names)


def test_the_table_has_every_option_and_its_default() -> None:
    shown = re.findall(r"^\| `(\w+)` \| (True|False|None|0) \|", TEXT, re.MULTILINE)
    usual = ControllerOptions()
    wanted = [(field.name, f"{getattr(usual, field.name)}") for field in fields(usual)]
    assert shown == [(name, "0" if default == "0.0" else default) for name, default in wanted]


def test_the_file_can_be_loaded() -> None:
    (example,) = blocks("toml")
    tolerant, late = Config.parse(example).board
    assert tolerant.options == ControllerOptions(fd_tolerant=True)
    assert late.options.loop_delay_ns == 255
    assert late.options.compensation is not None
