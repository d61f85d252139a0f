"""Whatever python-can opens, as a line's controller."""
