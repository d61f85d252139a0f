"""The hub's time on the clock of the wall, as the verbs call it."""

from canwire import epoch_ns

__all__ = ["epoch_ns"]
