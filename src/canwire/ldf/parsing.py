"""ldfparser with its grammar compiled once for all files.

ldfparser itself compiles its grammar for each file, which takes 0.1 s of processor time,
ten times that of a small file.
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
    """A copy of ldfparser's function in which the name `Lark` means `compiled`; ldfparser itself is not changed."""
    module = import_module("ldfparser.parser")

    kept = cache(module.Lark)

    def compiled(*, lexer_callbacks: object = None, **options: Any) -> Any:
        """The compiled grammar without the callbacks, which collect comments that canwire does not read."""
        return kept(**options)

    names = {**vars(module), "Lark": compiled}
    for name in ("parse_ldf_to_dict", "parse_ldf"):
        own = getattr(module, name)
        names[name] = FunctionType(own.__code__, names, name, own.__defaults__)
    return names["parse_ldf"]
