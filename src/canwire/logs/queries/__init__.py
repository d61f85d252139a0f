"""Queries traces with SQL: `open_trace` opens the files of a trace with DuckDB.

`trace.py` is the object, `sources.py` finds the Parquet files of a path, `views.py` defines the tables,
`signals.py` decodes while a query runs, and `mistakes.py` shortens an error of DuckDB to one line.
"""
