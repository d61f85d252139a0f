"""Vector's BLF: objects in compressed containers. CAN, CAN FD, error frames, LIN frames; other entries are texts.

Every `flush` ends a container and updates the header: the file can be read even if its writer is killed.

Source: the object layouts as public readers (python-can, vector_blf) describe them.
"""

from canwire.logs.blf.reading import read, recognises
from canwire.logs.blf.writing import Writer

__all__ = ["Writer", "read", "recognises"]
