"""Campaigns: a function is played thousands of times with seeds and parameters, and the results are a table."""
