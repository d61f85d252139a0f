"""An adapter of python-can, as text: `pcan/PCAN_USBBUS1`, `virtual/0`, `kvaser/0?single_handle=true`.

What stands before the / is python-can's `interface`, behind it the `channel`; arguments of that interface follow a ?.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from urllib.parse import parse_qsl, unquote

from canwire.errors import BadValue

_WORDS = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}
_OURS = ("interface", "channel", "bitrate", "data_bitrate", "timing", "fd", "ignore_config")


@dataclass(frozen=True, slots=True)
class Port:
    """Parsed; `channel` None leaves it to the interface."""

    text: str
    interface: str
    channel: str | None
    options: dict[str, Any]


def parse_port(text: str) -> Port:
    """Raises BadValue."""
    place, _, query = text.removeprefix("python-can:").partition("?")
    interface, _, channel = place.partition("/")
    if not interface.replace("_", "").replace("-", "").isalnum():
        raise BadValue(f"port {text!r}: python-can's interface and channel, pcan/PCAN_USBBUS1 perhaps")
    if (
        interface == "slcan"
    ):  # python-can's own takes no notice of BELL: what the adapter refuses counts as sent
        raise BadValue(
            f"port {text!r}: python-can's slcan does not hear when the adapter refuses a frame, which is lost then; "
            f"share it by canwire's own driver: canwire share {unquote(channel) or '/dev/ttyUSB0'}"
        )
    options = {name: _value(value) for name, value in parse_qsl(query, keep_blank_values=True)}
    for name in options:
        if name in _OURS or not name.isidentifier():
            raise BadValue(f"port {text!r}: no option {name!r}: the line's own settings say that")
    return Port(text, interface, unquote(channel) or None, options)


def _value(text: str) -> Any:
    if text.lower() in _WORDS:
        return _WORDS[text.lower()]
    for kind in (lambda: int(text, 0), lambda: float(text)):
        try:
            return kind()
        except ValueError:
            continue
    return text
