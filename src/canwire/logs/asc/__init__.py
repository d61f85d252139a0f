"""Vector's ASC: text with a line for each entry. CAN, CAN FD, error frames, LIN frames; other entries are comments.

Source: Vector's description of the ASC logging format, as shown by public logs and python-can.
"""

from canwire.logs.asc.reading import read, recognises
from canwire.logs.asc.writing import Writer

__all__ = ["Writer", "read", "recognises"]
