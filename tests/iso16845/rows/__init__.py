"""The rows of purposes.py, by chapter."""
