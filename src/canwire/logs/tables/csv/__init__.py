"""CSV with a row for each entry (columns.py). The CSV files of python-can and GVRET (SavvyCAN) are also read."""

from canwire.logs.tables.csv.reading import read, recognises
from canwire.logs.tables.csv.writing import Writer

__all__ = ["Writer", "read", "recognises"]
