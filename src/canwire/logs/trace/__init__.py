"""A trace: a folder of Parquet files, for logs that are bigger than memory. `open_log` reads it, DuckDB queries it.

Files have some million entries each, by identifier (tables/order.py). The one that grows is a journal until it is
whole: all that was flushed can be read whatever happens to the process.
"""

from canwire.logs.trace.reading import read, recognises
from canwire.logs.trace.writing import Writer

__all__ = ["Writer", "read", "recognises"]
