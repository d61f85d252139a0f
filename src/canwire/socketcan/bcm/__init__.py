"""CAN_BCM: the broadcast manager, which sends by itself and reports only changes."""
