"""CSV, a row for an entry (columns.py); read are python-can's and GVRET's (SavvyCAN's) as well."""

from canwire.logs.tables.csv.reading import read, recognises
from canwire.logs.tables.csv.writing import Writer

__all__ = ["Writer", "read", "recognises"]
