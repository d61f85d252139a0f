"""candleLight and other adapters that speak gs_usb's protocol, over USB; python-can's own driver knows less of it.

That one knows no CAN FD and no listening only, takes its own frames for received ones, and does not see that the
adapter was unplugged.
"""
