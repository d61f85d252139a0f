"""What people try that canwire does not have: names and calls, and what to write instead."""
