"""PEAK's TRC: versions 1.0 to 2.1 are read, 2.1 is written, with error frames, error counters and status changes.

Source: PEAK-System, "PEAK CAN TRC File Format" (2020-07-27).
"""

from canwire.logs.trc.reading import read, recognises
from canwire.logs.trc.writing import Writer

__all__ = ["Writer", "read", "recognises"]
