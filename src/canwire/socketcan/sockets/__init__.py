"""The server's side of a program's CAN sockets, one file for each protocol."""
