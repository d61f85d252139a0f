"""The bench's LIN buses and their nodes."""
