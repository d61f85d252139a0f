"""A driver of the MCP2515 that uses its instructions: for a simulated chip, or for a real one on an SPI interface."""
