"""What a trace of the wire will cost, said before it is written: every node looks at every bit, which is slow."""

from __future__ import annotations

from canwire import Frame

# measured on one core of a small machine with the compiled core, 2026-11; the uncompiled one takes far longer
_BIT_S, _BIT_OF_NODE_S = 1.3e-6, 0.22e-6
_BYTES_OF_BIT = 6  # of the file: two bits in five change the level, and a change takes 15 bytes
_WORTH_A_WORD = 1_000_000  # bytes
_STUFFED = 1.08  # with the usual share of stuff bits
_HEAD, _EXTENDED, _FD = 47, 20, 26  # bits besides the data: the intermission counts, FD's longer CRC too


def bits_of(frame: Frame) -> int:
    """About as many bits as the frame takes on the wire."""
    bits = _HEAD + 8 * len(frame.data) + _EXTENDED * frame.extended + _FD * frame.fd
    return round(bits * _STUFFED)


def forecast(bits: int, senders: int, one: bool) -> str:
    """How big the file will be and how long it takes, also with the other choice of --senders; "" for little."""
    size = bits * _BYTES_OF_BIT
    if size < _WORTH_A_WORD:
        return ""
    text = (
        f"the trace will have about {size / 1e6:.0f} MB and take about {_span(bits, 1 if one else senders)}"
    )
    if one and senders > 1:
        text += f"; with --senders each ({senders} nodes that arbitrate) {_span(bits, senders)}"
    return text


def _span(bits: int, senders: int) -> str:
    seconds = bits * (_BIT_S + _BIT_OF_NODE_S * (senders + 1))  # and the recorder
    if seconds < 1:
        return "a second"
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} minutes"
