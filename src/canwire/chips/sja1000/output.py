"""What the SJA1000's two output pins do, by the output control register.

Source: data sheet 6.5.3, tables 45 to 48; reference/sja1000.md section 8. What a transceiver makes of them is the
board's business (boards/transceiver.py): where none is wired, a chip's dominant bit is dominant whatever OCR says
[INT].
"""

from __future__ import annotations

from canwire.chips.sja1000 import register_map as m

FLOAT, LOW, HIGH, CLOCK = "float", "low", "high", "clock"
_TX0 = (m.OCR_OCTP0, m.OCR_OCTN0, m.OCR_OCPOL0)
_TX1 = (m.OCR_OCTP1, m.OCR_OCTN1, m.OCR_OCPOL1)
_MODE = 0x03


def pins(ocr: int, dominant: bool) -> tuple[str, str]:
    """Pins TX0 and TX1 in normal output mode while the chip sends a dominant or a recessive bit.

    Each is "low", "high" or "float"; in clock mode TX1 is "clock" instead (bi-phase and test mode are not modelled:
    their pins are as in normal mode).
    """
    tx1 = CLOCK if ocr & _MODE == m.OCR_CLOCK else _pin(ocr, _TX1, dominant)
    return _pin(ocr, _TX0, dominant), tx1


def _pin(ocr: int, bits: tuple[int, int, int], dominant: bool) -> str:
    """The state of one push-pull output: its upper transistor drives a 1, its lower one a 0, if enabled."""
    upper, lower, inverted = bits
    level = (not dominant) != bool(ocr & inverted)
    if level:
        return HIGH if ocr & upper else FLOAT
    return LOW if ocr & lower else FLOAT
