"""Where a serial adapter is, as text.

    /dev/ttyUSB0   COM3              a serial port, through pyserial
    socket://192.168.0.7:4001        a bridge to one; other URLs of pyserial too
    ?serial=A123                     the adapter with that serial number, wherever it is plugged in

Options follow a ?, separated by &: `baudrate` of the serial line, `serial` (the USB serial number or the adapter's own,
by which it is found again), `stamps=0` (do not change its setting of time stamps), `s7=750000` (the bit rate that S7
means), `timeout` (seconds to wait for an answer).
"""

from __future__ import annotations

from dataclasses import dataclass
from urllib.parse import parse_qsl

from canwire.errors import BadValue

USUAL_BAUDRATE = 115_200  # of no meaning to an adapter on USB
ANSWER_S = 0.5
_OPTIONS = ("baudrate", "serial", "stamps", "s7", "timeout")


@dataclass(frozen=True, slots=True)
class Port:
    """A parsed port; `url` is "" if only the serial number is known."""

    text: str
    url: str
    baudrate: int = USUAL_BAUDRATE
    serial: str = ""
    stamps: bool = True
    s7: int | None = None
    answer_s: float = ANSWER_S


def parse_port(text: str) -> Port:
    """The Port that this text describes; raises BadValue."""
    url, _, query = text.partition("?")
    options = dict(parse_qsl(query, keep_blank_values=True))
    for name in options:
        if name not in _OPTIONS:
            raise BadValue(f"port {text!r}: no option {name!r}; there are {', '.join(_OPTIONS)}")
    if url.startswith("socket://"):
        host, _, number = url.removeprefix("socket://").rstrip("/").rpartition(":")
        if not host or not number.isdigit() or not 0 < int(number) < 65_536:
            raise BadValue(f"port {text!r}: socket://host:port")
    port = Port(
        text,
        url,
        int(_number(text, options, "baudrate", USUAL_BAUDRATE)),
        options.get("serial", ""),
        options.get("stamps", "1") not in ("0", "no", "off"),
        int(_number(text, options, "s7", 0)) or None,
        _number(text, options, "timeout", ANSWER_S),
    )
    if not url and not port.serial:
        raise BadValue(f"port {text!r}: /dev/ttyUSB0, COM3, socket://host:port or ?serial=A123")
    return port


def _number(text: str, options: dict[str, str], name: str, usual: float) -> float:
    try:
        value = float(options.get(name, usual))
    except ValueError:
        value = -1.0
    if not 0 <= value < 1e9 or (name == "timeout" and value == 0):
        raise BadValue(f"port {text!r}: {name} is a number above 0")
    return value
