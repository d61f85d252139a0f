"""The hub: one set of boards that several processes share."""
