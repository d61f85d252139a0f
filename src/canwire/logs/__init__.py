"""Logs of buses as files: read (`open_log`), written (`create_log`), recorded from a line (`record`), converted.

`entry.py` is one line of a log, `batch.py` many as numpy records, `formats.py` the table of formats. A format is a
folder or a file with `read(source)`, a generator of batches, and `Writer`; a new one is that and a row of the table.
"""
