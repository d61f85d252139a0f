"""Logs of what happens now: `record` writes a line of the hub, or a node or bus of the lab, to files."""
