"""MF4 by asammdf, in ASAM's layout for bus logging. Needs canwire[mf4].

A group for data frames, remote frames and error frames each, and one for LIN frames; what others see are the structures
CAN_DataFrame, CAN_RemoteFrame, CAN_ErrorFrame, LIN_Frame. Stamps are seconds from the head's date, in doubles: exact to
a nanosecond for the first 100 days. Readable once it is closed.

Source: ASAM MDF Bus Logging 1.0 names, as asammdf and python-can use them.
"""

from canwire.logs.mf4.reading import read, recognises
from canwire.logs.mf4.writing import Writer

__all__ = ["Writer", "read", "recognises"]
