"""Mutants of the source, and which of them the tests notice: `python -m tests.mutants --seed 26 --count 150 --out FILE`."""
