"""What other packages ship for their own tests, read by us and by them."""
