"""`canwire devices`: the boards of the hub, their lines, and who uses them."""
