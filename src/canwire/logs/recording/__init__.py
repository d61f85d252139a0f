"""Records live traffic: `record` writes a line of the hub, or a node or bus of a lab, to files."""
