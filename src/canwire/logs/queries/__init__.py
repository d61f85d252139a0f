"""Traces by SQL: `open_trace` puts DuckDB over a trace's files.

`trace.py` is the object, `sources.py` finds the Parquet files behind a path, `views.py` says what tables there are,
`signals.py` decodes while a query runs, `mistakes.py` makes one line of what DuckDB says of a query.
"""
