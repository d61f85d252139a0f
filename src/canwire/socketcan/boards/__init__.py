"""Boards and the hub itself come and go."""
