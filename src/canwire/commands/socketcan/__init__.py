"""`canwire run` and `canwire bridge`."""
