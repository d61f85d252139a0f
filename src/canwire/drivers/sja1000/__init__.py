"""The SJA1000 driven through its registers: a simulated one, or a real one behind ports."""
