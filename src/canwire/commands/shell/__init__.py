"""What the command is towards shells and terminals: how words are read, how it ends, colours, completion."""
