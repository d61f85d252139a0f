"""Logs as tables: a row for each entry, with the same columns in CSV, Parquet and SQLite (`columns.py`)."""
