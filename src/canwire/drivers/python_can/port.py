"""An adapter of python-can, as text: `pcan/PCAN_USBBUS1`, `virtual/0`, `kvaser/0?single_handle=true`.

The part before the / is python-can's `interface`, the part after it the `channel`; arguments for it follow a ?.
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
    """A parsed port; with `channel` None the interface chooses its channel."""

    text: str
    interface: str
    channel: str | None
    options: dict[str, Any]


def parse_port(text: str) -> Port:
    """The Port that this text describes; raises BadValue."""
    place, _, query = text.removeprefix("python-can:").partition("?")
    interface, _, channel = place.partition("/")
    if not interface.replace("_", "").replace("-", "").isalnum():
        raise BadValue(
            f"port {text!r}: python-can's interface and channel are needed, such as pcan/PCAN_USBBUS1"
        )
    if (
        interface == "slcan"
    ):  # python-can's own takes no notice of BELL: what the adapter refuses counts as sent
        raise BadValue(
            f"port {text!r}: python-can's slcan does not notice when the adapter refuses a frame, which is then lost; "
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
