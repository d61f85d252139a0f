"""The roles in which a client opens a FIFO: to monitor it, or as one of its two ends."""

from __future__ import annotations

FIFO, READER, WRITER = "fifo", "reader", "writer"
