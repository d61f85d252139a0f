"""can-isotp on a line of the hub: its identifiers and parameters from a command line, and its transport layer."""

from __future__ import annotations

import argparse
import logging
import re
from contextlib import ExitStack
from importlib import import_module
from typing import TYPE_CHECKING, Any

from canwire import BadValue, CanwireError, ChannelMode, ExtraMissing, Frame, every_line
from canwire.commands.can_line import add_line_arguments, add_timeout_argument, bring_up, wanted_by
from canwire.commands.send import Sending
from canwire.commands.shared_hub import find_line

if TYPE_CHECKING:
    from canwire import Hub

_QUEUE = 4096
_EXTENSION = re.compile(r"([0-9A-Fa-f]{1,2})(?::([0-9A-Fa-f]{1,2}))?")
_ID = re.compile(r"(?:0x)?([0-9A-Fa-f]{1,8})")


def add_transport_arguments(parser: argparse.ArgumentParser, *, tx: str = "7E0", rx: str = "7E8") -> None:
    """Add LINE, the identifiers and the parameters of ISO-TP."""
    add_line_arguments(parser)
    parser.add_argument(
        "-s", "--tx", default=tx, metavar="ID", help=f"identifier of sent frames; 8 digits: 29 bits ({tx})"
    )
    parser.add_argument("-d", "--rx", default=rx, metavar="ID", help=f"identifier of received frames ({rx})")
    parser.add_argument(
        "-x",
        "--extended",
        metavar="TO[:FROM]",
        help="extended addressing: the byte before sent data and, if it differs, before received data: F1:12",
    )
    parser.add_argument("--fd", action="store_true", help="send CAN FD frames of up to 64 bytes, with BRS")
    parser.add_argument("--pad", metavar="HEX", help="pad frames with this byte: CC")
    parser.add_argument(
        "--bs", type=int, default=0, metavar="COUNT", help="block size to request, in frames (0: all frames)"
    )
    parser.add_argument(
        "--stmin", type=int, default=0, metavar="MS", help="time between frames to request, 0 to 127 ms (0)"
    )
    add_timeout_argument(parser)


def load(library: str) -> Any:
    """Import can-isotp or udsoncan and silence its logging, which would repeat our messages; raises ExtraMissing."""
    for logger in ("isotp", "udsoncan", "UdsClient", "Connection"):
        logging.getLogger(logger).addHandler(logging.NullHandler())
    try:
        return import_module(library)
    except ModuleNotFoundError:
        raise ExtraMissing({"isotp": "can-isotp"}.get(library, library), "protocols") from None


def parsed_id(option: str, text: str) -> tuple[int, bool]:
    """Return the identifier, and whether it has 29 bits (eight digits, or above 7FF). Raises BadValue."""
    found = _ID.fullmatch(text)
    number = int(found[1], 16) if found else -1
    if found is None or number > 0x1FFFFFFF:
        raise BadValue(f"{option} {text}: an identifier in hex, 7E0 or 18DA10F1")
    return number, len(found[1]) == 8 or number > 0x7FF


def address_of(arguments: argparse.Namespace, *, swapped: bool = False) -> Any:
    """Return can-isotp's address of --tx and --rx; `swapped`: the other side's. Raises BadValue."""
    isotp = load("isotp")
    (tx, extended), (rx, other) = parsed_id("--tx", arguments.tx), parsed_id("--rx", arguments.rx)
    if extended != other:
        raise BadValue(f"--tx {arguments.tx} --rx {arguments.rx}: both of 11 bits, or both of 29")
    if tx == rx:
        raise BadValue(f"--tx {arguments.tx}: the same as --rx; the two sides need different identifiers")
    modes = isotp.AddressingMode
    sent, received = parsed_extension(arguments.extended)
    if swapped:
        tx, rx, sent, received = rx, tx, received, sent
    if sent is None:
        return isotp.Address(modes.Normal_29bits if extended else modes.Normal_11bits, txid=tx, rxid=rx)
    mode = modes.Extended_29bits if extended else modes.Extended_11bits
    return isotp.Address(mode, txid=tx, rxid=rx, target_address=sent, source_address=received)


def parsed_extension(text: str | None) -> tuple[int | None, int | None]:
    """Return the bytes before sent and before received data; None without extended addressing. Raises BadValue."""
    if text is None:
        return None, None
    found = _EXTENSION.fullmatch(text)
    if found is None:
        raise BadValue(f"--extended {text}: one or two bytes in hex, F1 or F1:12")
    return int(found[1], 16), int(found[2] or found[1], 16)


def params_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return can-isotp's parameters; raises BadValue."""
    if not 0 <= arguments.stmin <= 127:
        raise BadValue(f"--stmin {arguments.stmin}: 0 to 127 ms")
    if not 0 <= arguments.bs <= 255:
        raise BadValue(f"--bs {arguments.bs}: 0 to 255 frames")
    if arguments.pad is not None and not re.fullmatch("[0-9A-Fa-f]{1,2}", arguments.pad):
        raise BadValue(f"--pad {arguments.pad}: a byte in hex, CC")
    return {
        "stmin": arguments.stmin,
        "blocksize": arguments.bs,
        "tx_padding": None if arguments.pad is None else int(arguments.pad, 16),
        "can_fd": arguments.fd,
        "bitrate_switch": arguments.fd,
        "tx_data_length": 64 if arguments.fd else 8,
        "max_frame_size": 0xFFFF_FFFF,
        "rx_flowcontrol_timeout": round(arguments.timeout * 1000),
        "rx_consecutive_frame_timeout": round(arguments.timeout * 1000),
    }


class IsoTpLine:
    """A line that is open for ISO-TP: `layer` is can-isotp's, started; `errors` are its errors, in order."""

    def __init__(self, hub: Hub, arguments: argparse.Namespace, closing: ExitStack) -> None:
        isotp, address, params = load("isotp"), address_of(arguments), params_of(arguments)
        lines = every_line(hub)
        self.place = find_line(hub, arguments.line, to_send=True, among=lines)
        self.channel = closing.enter_context(hub.open_channel(self.place.board.id, self.place.line))
        self.channel.set_up(ChannelMode(receive=_QUEUE, transmit=_QUEUE))
        bring_up(hub, self.place, wanted_by(arguments), among=lines)
        self.channel.activate()
        self.sending = Sending(hub, self.place, self.channel, arguments.timeout)
        self.errors: list[Exception] = []
        self._made = isotp.CanMessage
        self.layer = isotp.TransportLayer(
            self._take, self._put, address=address, error_handler=self.errors.append, params=params
        )
        self.layer.start()
        closing.callback(self.layer.stop)

    def _take(self, timeout: float) -> Any:
        try:
            frame = self.channel.receive(timeout)
        except CanwireError as error:
            if not self.errors or self.errors[-1] is not error:
                self.errors.append(error)
            return None
        return None if frame is None or frame.remote else message_of(frame, self._made)

    def _put(self, message: Any) -> None:
        """Queue a message's frame; `sending.result` reports a queue that stays full."""
        frame = Frame(
            message.arbitration_id,
            bytes(message.data),
            extended=message.is_extended_id,
            fd=message.is_fd,
            bit_rate_switch=message.is_fd and message.bitrate_switch,
        )
        self.sending.queue(frame)


def message_of(frame: Frame, made: Any) -> Any:
    """Return the frame as a message of can-isotp."""
    return made(
        frame.id,
        frame.dlc,
        frame.data,
        extended_id=frame.extended,
        is_fd=frame.fd,
        bitrate_switch=frame.bit_rate_switch,
    )
