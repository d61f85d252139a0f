"""`canwire isotp` and `canwire uds`."""
