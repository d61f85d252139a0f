"""Reads text logs in blocks of lines: `reading.py` keeps the order, `fields.py` reads columns.

A format says which lines are plain and makes records of all plain lines with numpy. Every other line is read
separately, as in `lines.py`, so faults are reported in the same way.
"""
