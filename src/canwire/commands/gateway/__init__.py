"""`canwire bridge`: passes frames between two buses."""
