"""`canwire timing`: single bit timings, and the timings of all nodes on a bus."""
