"""Logs as tables: a row for an entry, in columns that mean the same in CSV, Parquet and SQLite (`columns.py`)."""
