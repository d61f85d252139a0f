"""A second opinion on the CAN wire: slow, obvious, written from the standard's rules and not from the bus's code.

Nothing here but schedule.py's players imports canwire. Source: ISO 11898-1:2015; reference/can-protocol.md.
"""
