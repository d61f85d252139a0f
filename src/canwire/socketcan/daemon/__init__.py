"""socketcand's protocol over TCP, for programs that reach CAN that way: Kayak, SavvyCAN, python-can's `socketcand`."""
