"""Log files of buses: read (`open_log`), write (`create_log`), record from a line (`record`), convert.

`entry.py` is one entry of a log, `batch.py` many entries as numpy records, `formats.py` the table of formats. A format
is a module with `read(source)`, a generator of batches, and `Writer`; a new format needs that and a row in the table.
"""
