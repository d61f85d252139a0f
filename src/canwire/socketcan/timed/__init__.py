"""SocketCAN programs that keep one time with others."""
