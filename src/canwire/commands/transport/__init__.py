"""`canwire isotp` and `canwire uds`: can-isotp and udsoncan on lines of the hub."""
