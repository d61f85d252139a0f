"""Verbs and arguments that use a network description: messages and signals by name."""
