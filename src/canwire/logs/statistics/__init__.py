"""Statistics of a log: `log_statistics` reads it once, batch by batch, in memory that does not grow with it.

`collecting.py` passes each batch to `periods.py`, which counts by identifier, `channels.py`, which counts by channel,
and `busy.py`, which adds up the time that frames occupied the bus (`wire_bits.py` computes their lengths). `results.py`
defines the results.
"""
