"""`canwire devices`: the boards of the hub, their lines, and the programs that use them."""
