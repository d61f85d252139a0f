"""Names and calls that users try although canwire does not have them, and what to write instead."""
