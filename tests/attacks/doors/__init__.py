"""Every public callable with values that it was not made for, in a process of its own, in both forms of the core."""
