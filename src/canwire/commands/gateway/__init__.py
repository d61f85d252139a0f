"""`canwire bridge`: two buses, and what passes between them."""
