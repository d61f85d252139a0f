"""A driver of the SJA1000 that uses its registers: for a simulated chip, or for a real one behind I/O ports."""
