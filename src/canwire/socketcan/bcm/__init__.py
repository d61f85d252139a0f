"""CAN_BCM: the broadcast manager, which sends by itself and tells only what changes."""
