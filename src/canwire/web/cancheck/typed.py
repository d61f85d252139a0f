"""A generator's window as it was typed, and as it is shown again: every fault at its field.

Fields: id, dlc, b0 to b7, rtr, ext, delay, range; with `range` also idto, t0 to t7, wrap, repeat. All numbers but the
delay are hexadecimal. Source: CANDRV manual, 10.4.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire import BadFrame
from canwire.candrv.filters import aligned, identifier_of
from canwire.web.cancheck.recipe import MOST_DATA, Range, Recipe

if TYPE_CHECKING:
    from canwire.web.fields import Fields
    from canwire.web.words import Words

DWORD = 0xFFFF_FFFF


def typed_recipe(fields: Fields, word: Words, *, align: int, extended: bool) -> Recipe:
    """Return the recipe of the typed fields; `extended`: the device is in CAN2.0B. Raises BadFields."""
    ext, use_range = fields.flag("ext"), fields.flag("range")
    if ext and not extended:
        fields.fault("ext", word("cancheck.only-2b"))
    count = fields.hexadecimal("dlc", 0, MOST_DATA)
    identifier = _identifiers(fields, align, ext, use_range)
    data = tuple(_bytes(fields, place, use_range) for place in range(count))
    delay_ms = fields.whole("delay", 0, DWORD)
    fields.check()
    return Recipe(
        identifier,
        data,
        fields.flag("rtr"),
        ext,
        delay_ms,
        use_range,
        wrap=use_range and fields.flag("wrap"),
        repeat=use_range and fields.flag("repeat"),
    )


def _identifiers(fields: Fields, align: int, extended: bool, use_range: bool) -> Range:
    first = _identifier(fields, "id", align, extended)
    return Range(first, _identifier(fields, "idto", align, extended) if use_range else first)


def _identifier(fields: Fields, name: str, align: int, extended: bool) -> int:
    word = fields.hexadecimal(name, 0, DWORD)
    try:
        return identifier_of(word, extended, align)
    except BadFrame as error:
        fields.fault(name, str(error))
        return 0


def _bytes(fields: Fields, place: int, use_range: bool) -> Range:
    first = fields.hexadecimal(f"b{place}", 0, 0xFF)
    return Range(first, fields.hexadecimal(f"t{place}", 0, 0xFF) if use_range else first)


def shown_recipe(recipe: Recipe, align: int) -> dict[str, str | bool]:
    """Return the values of the fields for a recipe that is to be edited."""
    shown: dict[str, str | bool] = {
        "id": f"{aligned(recipe.identifier.first, recipe.extended, align):X}",
        "idto": f"{aligned(recipe.identifier.last, recipe.extended, align):X}",
        "dlc": f"{len(recipe.data):X}",
        "rtr": recipe.rtr,
        "ext": recipe.extended,
        "delay": str(recipe.delay_ms),
        "range": recipe.use_range,
        "wrap": recipe.wrap,
        "repeat": recipe.repeat,
    }
    for place, one in enumerate(recipe.data):
        shown[f"b{place}"] = f"{one.first:02X}"
        shown[f"t{place}"] = f"{one.last:02X}"
    return shown
