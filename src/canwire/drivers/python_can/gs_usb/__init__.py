"""The driver of candleLight and other USB adapters with the gs_usb protocol.

It replaces python-can's own driver, which supports neither CAN FD nor listen-only mode, returns its own frames as
received ones, and does not notice that the adapter was unplugged.
"""
