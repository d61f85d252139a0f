"""`canwire campaign`: thousands of labs by number."""
