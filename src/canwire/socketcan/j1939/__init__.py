"""SAE J1939 as in Linux' CAN_J1939 sockets: addresses, and messages of any length. No I/O; times are arguments."""
