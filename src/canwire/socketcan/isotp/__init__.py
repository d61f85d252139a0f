"""CAN_ISOTP: messages of up to 66,000 bytes in frames (ISO 15765-2). No I/O; times are arguments."""
