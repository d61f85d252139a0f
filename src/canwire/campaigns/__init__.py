"""Thousands of labs by number: a function is played with seeds and parameters, and what came of it is a table."""
