"""`canwire campaign`: thousands of numbered runs of a Lab."""
