"""The helper process of a program in C: it has the connection to the hub, and answers the less frequent calls."""
