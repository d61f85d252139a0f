"""MF4 by asammdf, in ASAM's layout for bus logging. Needs canwire[mf4].

Data frames, remote frames, error frames and LIN frames have a group each; other programs see the structures
CAN_DataFrame, CAN_RemoteFrame, CAN_ErrorFrame, LIN_Frame. Time stamps are seconds from the header's date, in doubles:
exact to a nanosecond for the first 100 days. The file is readable once it is closed.

Source: ASAM MDF Bus Logging 1.0 names, as asammdf and python-can use them.
"""

from canwire.logs.mf4.reading import read, recognises
from canwire.logs.mf4.writing import Writer

__all__ = ["Writer", "read", "recognises"]
