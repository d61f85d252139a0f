"""Reads each signal of a frame separately, where cantools, which reads whole messages, would fail or read wrong bits.

These are messages with signals that overlap or do not fit, in a file that was not loaded strictly, and messages with
multiplexers that cantools does not support: with a long name, of a DBC file that writes m for M, or without signals."""

from __future__ import annotations

import struct

from canwire.databases.description import MessageDescription, Number, SignalDescription
from canwire.databases.field import end_bit

_FLOATS = {16: ">e", 32: ">f", 64: ">d"}


def read_one_by_one(message: MessageDescription, data: bytes) -> tuple[dict[str, Number], str]:
    """Raw values of the signals in the data, and a text: why there are none, or which do not fit into the message."""
    data = data[: message.length]
    raws: dict[str, Number] = {}
    for signal in message.signals.values():
        if end_bit(signal) <= 8 * len(data) and _chosen(message, signal, data):
            raws[signal.name] = _raw(signal, data)
    for name, known in message.selectors.items():
        if name in raws and raws[name] not in known:
            return {}, f"{name}: {raws[name]} chooses no signals"
    unfit = [one.name for one in message.signals.values() if end_bit(one) > 8 * message.length]
    return raws, f"not in {message.length} bytes: {', '.join(unfit)}" if unfit else ""


def _chosen(message: MessageDescription, signal: SignalDescription, data: bytes) -> bool:
    if not signal.multiplexer:
        return True
    decides = message.signals[signal.multiplexer]
    if end_bit(decides) > 8 * len(data) or not _chosen(message, decides, data):
        return False
    return _raw(decides, data) in signal.multiplexer_ids


def _raw(signal: SignalDescription, data: bytes) -> Number:
    if signal.big_endian:
        bits = int.from_bytes(data, "big") >> 8 * len(data) - end_bit(signal)
    else:
        bits = int.from_bytes(data, "little") >> signal.start_bit
    bits &= (1 << signal.length) - 1
    if signal.is_float:
        number: float = struct.unpack(_FLOATS[signal.length], bits.to_bytes(signal.length // 8, "big"))[0]
        return number
    return bits - (1 << signal.length) if signal.signed and bits >> signal.length - 1 else bits
