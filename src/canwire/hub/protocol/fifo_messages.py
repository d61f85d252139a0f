"""Requests and replies about FIFOs that programs share through the hub."""

from __future__ import annotations

from canwire.hub.protocol.message import Message


class CreateFifo(Message):
    """-> FifoOpened (role "fifo"). Elements of `element_size` bytes, 1..65535; at least `capacity` of them."""

    capacity: int
    element_size: int


class OpenFifo(Message):
    """-> FifoOpened, with descriptors: memory, the reader's event, the writer's event. One reader, one writer."""

    fifo: int
    role: str


class ResetFifo(Message):
    """Fifo -> None; refused while a reader or writer is open."""

    handle: int


class FifoOpened(Message):
    handle: int
    fifo: int
    capacity: int
    element_size: int
