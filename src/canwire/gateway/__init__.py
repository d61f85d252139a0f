"""Two buses joined by rules: which frames pass, their new identifiers, changes to data, and a limit per second."""
