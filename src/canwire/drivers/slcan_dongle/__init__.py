"""The driver of serial adapters with the ASCII protocol of the CANBUS dongle (SLCAN, LAWICEL)."""
