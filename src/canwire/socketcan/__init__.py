"""SocketCAN without the kernel's drivers: programs that use it see a hub's lines as CAN interfaces.

`canwire run` starts a program with the shim (shim/, plain C) preloaded and serves what the program asks of its CAN
sockets. Sources: linux/can.h, can/raw.h, can/bcm.h, can/isotp.h, can/error.h.
"""
