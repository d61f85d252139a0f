"""Statistics of a log: `log_statistics` reads it once, batch by batch, in memory that does not grow with it.

`collecting.py` hands each batch to those who count: `periods.py` by identifier, `channels.py` by channel, `busy.py` how
long frames kept the bus (`wire_bits.py` has their lengths). `results.py` is what comes out.
"""
