"""A server with socketcand's protocol over TCP, for Kayak, SavvyCAN, python-can's `socketcand` and others."""
