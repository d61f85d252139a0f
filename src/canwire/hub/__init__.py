"""Several processes, one set of boards."""
