"""SocketCAN programs in lockstep time."""
