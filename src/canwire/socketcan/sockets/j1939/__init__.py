"""CAN_J1939 sockets: what a program asks of them, the bus they share, their error queues."""
