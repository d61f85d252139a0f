"""Two buses joined by rules: which frames pass, under which identifiers, changed how, and how many a second."""
