"""The driver of adapters that python-can opens."""
