"""Logs that are lines of text, a block of lines at a time: `reading.py` has the order, `fields.py` the columns.

A format says which lines are plain, and gives records of all of these at once, by numpy; every other line is read by
itself, as in `lines.py`, so whatever is wrong in it is told alike.
"""
