"""Queries traces with SQL: `open_trace` opens the files of a trace with DuckDB.

`trace.py` is the object, `sources.py` finds the Parquet files behind a path, `views.py` says what tables there are,
`signals.py` decodes while a query runs, `mistakes.py` shortens an error of DuckDB to one line.
"""
