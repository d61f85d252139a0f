"""The smallest cause of a run that failed: fewer faults, fewer frames, simpler parameters."""
