"""The MCP2515 driven through its instructions: a simulated one, or a real one behind an SPI interface."""
