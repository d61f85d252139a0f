"""Writes docs/configuration.md: canwire.toml in full, from the tables that the hub reads it with.

python docs/configuration.py
"""

from __future__ import annotations

from pathlib import Path

from canwire.boards import kinds
from canwire.boards.board import CAN, BoardKind
from canwire.boards.config.tables import Option, options

PAGE = Path(__file__).resolve().parent / "configuration.md"
HEAD = """# canwire.toml

Written by `python docs/configuration.py` from `boards/config/tables.py` and `boards/kinds.py`: change those instead.

`canwire serve --config FILE`, `canwire.connect(config=FILE)` and `canwire.serve(config=FILE)` read which buses there
are and which boards are plugged in. Without a file there are the buses `can0` and `lin0`, and
{usual}.

```toml
[[bus]]
name = "can0"
bit_rate = 500000
data_bit_rate = 2000000

[[bus]]
name = "body"
bit_rate = 125000
length_m = 40

[[bus]]
name = "lin0"
type = "lin"

[[board]]
kind = "usb-to-can-fd"
serial = "HW123456"
buses = ["can0", "body", "lin0"]
```

A file with a mistake is refused whole, with the place: `canwire.toml: bus[1].name: 'can0' twice; bus[0] has it too`.
A file without `[[bus]]` has `can0` and `lin0`; one without `[[board]]` has no boards until `canwire plug` brings some.
A LIN connector may be left out of `buses`; it is unconnected if its default bus does not exist.

"""
TABLE = "| key | type | default | |\n|---|---|---|---|\n"
KINDS = """
## Kinds of boards

| `kind` | is | connectors |
|---|---|---|
"""
TAIL = """
A package can add kinds of boards through an entry point `canwire.boards`. The kinds `slcan` and `python-can` are real
adapters: [adapters](adapters.md).

## CANDRV's registry

Tables `[candrv.CID1]` hold the registry of CANDRV's devices: [porting CANDRV](porting-candrv.md).
"""


def table(name: str) -> str:
    rows = "".join(row(option) for option in options() if option.table == name)
    return f"## [[{name}]]\n\n{TABLE}{rows}\n"


def row(option: Option) -> str:
    default = "" if option.default in (None, "", ()) else f"`{str(option.default).lower()}`"
    return f"| `{option.name}` | {option.type} | {default} | {option.help} |\n"


def kind_row(kind: BoardKind) -> str:
    connectors = ", ".join(
        f"{one.bus_type} ({'its own' if kind.outside else one.controller})"
        if one.bus_type == CAN
        else one.bus_type
        for one in kind.connectors
    )
    return f"| `{kind.name}` | {kind.description} | {connectors} |\n"


def page() -> str:
    usual = ", ".join(f"`{name}` (HW{number:06})" for number, name in enumerate(kinds.USUAL_BOARDS, 1))
    listed = "".join(kind_row(kind) for kind in kinds.KINDS.values())
    return (
        HEAD.format(usual=usual) + table("bus") + table("board").rstrip("\n") + "\n" + KINDS + listed + TAIL
    )


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
