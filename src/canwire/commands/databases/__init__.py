"""Verbs and words by a network's description: messages and signals by name."""
