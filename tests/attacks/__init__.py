"""Attacks on everything that strangers reach: whatever comes in, canwire answers in its own words and lives on."""
