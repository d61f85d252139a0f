"""Mutants of the source, and which of them the tests notice: `python -m tests.mutants --out FILE`."""
