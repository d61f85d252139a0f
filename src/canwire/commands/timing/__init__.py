"""`canwire timing`: bit timings by themselves, and those of nodes of one bus."""
