"""ldfparser with its grammar compiled once.

By itself it compiles it for each file, which takes 0.1 s of the processor, ten times what a small file takes.
Source: ldfparser 0.26, `parser.py`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module
from types import FunctionType
from typing import Any

from canwire.errors import ExtraMissing


def parse_ldf() -> Callable[..., Any]:
    """ldfparser's function of this name; raises ExtraMissing."""
    try:
        import_module("ldfparser")
    except ModuleNotFoundError:
        raise ExtraMissing("ldfparser", "lin") from None
    return _with_one_grammar()


@cache
def _with_one_grammar() -> Callable[..., Any]:
    """A copy of the function for which the name `Lark` means `compiled`; ldfparser itself stays as it is."""
    module = import_module("ldfparser.parser")

    @cache
    def kept(grammar: str, parser: str, propagate_positions: bool) -> Any:
        return module.Lark(grammar, parser=parser, propagate_positions=propagate_positions)

    def compiled(
        *, grammar: str, parser: str, propagate_positions: bool, lexer_callbacks: dict[str, Any]
    ) -> Any:
        """Without the callbacks, which collect comments that are not asked for."""
        return kept(grammar, parser, propagate_positions)

    names = {**vars(module), "Lark": compiled}
    for name in ("parse_ldf_to_dict", "parse_ldf"):
        own = getattr(module, name)
        names[name] = FunctionType(own.__code__, names, name, own.__defaults__)
    return names["parse_ldf"]
