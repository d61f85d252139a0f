"""canwire.toml: which buses a hub has, and which boards are plugged in when it starts.

    [[bus]]
    name = "can0"
    bit_rate = 500000

    [[board]]
    kind = "usb-to-can-fd"
    serial = "HW000001"
    buses = ["can0", "can0", "lin0"]

    [[board]]
    kind = "inducan104"
    base = 0x280

Every option is described in tables.py. A file without [[bus]] defines the buses can0 and lin0. A file without [[board]]
defines no boards; programs can plug them in. Without a file, the hub has the default boards of rulings.md 30.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import msgspec

from canwire.boards.config.check import Check
from canwire.boards.config.complaint import complaint
from canwire.boards.config.limits import LIMITS, LimitsConfig
from canwire.boards.config.tables import TABLES, BoardConfig, BusConfig
from canwire.boards.kinds import USUAL_BOARDS, USUAL_BUS, USUAL_LIN_BUS
from canwire.errors import BadConfig


class Config(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The whole file, checked: its names exist, and a hub can run it."""

    bus: tuple[BusConfig, ...] = (
        BusConfig(name=USUAL_BUS, data_bit_rate=2_000_000),
        BusConfig(name=USUAL_LIN_BUS, type="lin"),
    )
    board: tuple[BoardConfig, ...] = ()
    limits: LimitsConfig = LimitsConfig()
    candrv: Any = {}  # [candrv.CID1] ...: CANDRV's registry, which canwire.candrv checks

    @classmethod
    def load(cls, path: str | Path) -> Config:
        """The configuration in a file; raises BadConfig with the file and the place."""
        try:
            text = Path(path).read_bytes().decode("utf-8")
        except OSError as error:
            raise BadConfig(f"{path}: {error.strerror}") from None
        except UnicodeDecodeError as error:
            raise BadConfig(f"{path}: byte {error.start} is no UTF-8: {error.reason}") from None
        return cls.parse(text, str(path))

    @classmethod
    def parse(cls, text: str, source: str = "canwire.toml") -> Config:
        """The configuration in a text, which messages call `source`. Raises BadConfig."""
        try:
            text.encode()  # lone surrogates, which files cannot contain, but strings can
            data = tomllib.loads(text)
        except ValueError as error:
            raise BadConfig(f"{source}: {error}") from None
        except RecursionError:
            raise BadConfig(f"{source}: nested too deep") from None
        try:
            config = msgspec.convert(data, cls, strict=True)
        except msgspec.ValidationError as error:
            tables = {name: kind.__struct_fields__ for name, kind in TABLES.items()}
            tables[LIMITS] = LimitsConfig.__struct_fields__
            raise BadConfig(f"{source}: {complaint(str(error), data, tables)}") from None
        if data and data.keys() <= {"candrv", LIMITS}:  # these alone unplug nothing
            config = msgspec.structs.replace(cls.default(), candrv=config.candrv, limits=config.limits)
        Check(config.bus, config.board, source).run()
        return config

    @classmethod
    def default(cls) -> Config:
        """The configuration without a file: four boards, all on one bus (source: rulings.md 30)."""
        kinds = enumerate(USUAL_BOARDS, 1)
        return cls(board=tuple(BoardConfig(kind=name, serial=f"HW{number:06}") for number, name in kinds))
