"""The bench's CAN buses, their nodes, and what nodes do by themselves."""
