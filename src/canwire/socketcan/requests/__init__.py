"""Requests of shims to the server, one message each."""
