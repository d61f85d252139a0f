"""How the command is towards shells and terminals."""
