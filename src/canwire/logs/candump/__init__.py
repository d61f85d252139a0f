"""candump's formats: log lines (-l, -L, also with -x) and screen lines. LIN frames are as in `canwire lin dump -l`."""

from canwire.logs.candump.reading import entries, read, recognises
from canwire.logs.candump.writing import Writer

__all__ = ["Writer", "entries", "read", "recognises"]
