"""The LIN buses of a lab and their nodes."""
