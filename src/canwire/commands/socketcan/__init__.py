"""`canwire run` and `canwire socketcand`."""
