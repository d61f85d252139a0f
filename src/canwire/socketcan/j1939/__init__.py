"""SAE J1939 as Linux' CAN_J1939 sockets have it: addresses, messages of any length, without I/O; time is handed in."""
