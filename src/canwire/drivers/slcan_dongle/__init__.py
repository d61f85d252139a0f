"""A serial adapter that speaks the CANBUS dongle's ASCII protocol (SLCAN, LAWICEL), as a line's controller."""
