"""A trace: a folder of Parquet files, for logs larger than memory. `open_log` reads it, DuckDB queries it.

Files have some million entries each, sorted by identifier (tables/order.py). The growing file is a journal until it is
complete: flushed entries can be read even if the process is killed.
"""

from canwire.logs.trace.reading import read, recognises
from canwire.logs.trace.writing import Writer

__all__ = ["Writer", "read", "recognises"]
