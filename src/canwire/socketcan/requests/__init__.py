"""What shims ask the server for, one message each."""
