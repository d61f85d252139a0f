"""python-can's own interface for IXXAT on Windows: it sends 123 every 20 ms, says once it has heard 321 and 456."""

import os
import sys

import can

os.add_dll_directory(sys.argv[1])
with can.Bus(interface="ixxat", channel=0, unique_hardware_id="HW000002", bitrate=500_000) as bus:
    bus.send_periodic(can.Message(arbitration_id=0x123, data=b"\x11\x22", is_extended_id=False), 0.02)
    print("sending", flush=True)
    missing = {0x321, 0x456}
    while missing:
        message = bus.recv(60)
        assert message is not None, f"{missing} were not heard"
        missing.discard(message.arbitration_id)
    print("heard 321 and 456", flush=True)
    sys.stdin.read()
