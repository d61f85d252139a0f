"""IVciFifo and IVciFifo2, and how one interface of a FIFO leads to the others.

A FIFO made by `create_fifo` exists while any program has an interface of it; the FIFO of a channel or monitor belongs
to that, which uses one end of the FIFO itself.
Source: VCI V4 manual 4.1, 6.1.12, 6.1.13, 6.2.1 and 6.4.1.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Protocol
from uuid import UUID

from canwire import NoSuchBoard, WrongState
from canwire.vci.fifo.elements import Plain
from canwire.vci.fifo.fifo import FifoReader, FifoWriter
from canwire.vci.structures.errors import (
    VCI_E_ACCESSDENIED,
    VCI_E_NOINTERFACE,
    VCI_E_OBJECTID_NOT_FOUND,
    VciError,
)
from canwire.vci.structures.guids import (
    IID_IFifoReader,
    IID_IFifoWriter,
    IID_IUnknown,
    IID_IVciFifo,
    IID_IVciFifo2,
)
from canwire.vci.translation import meaning
from canwire.vci.unknown import Unknown, interface_name, vci_call

if TYPE_CHECKING:
    from canwire import Fifo, Hub, Ring, RingEnd
    from canwire.vci.fifo.elements import Elements

_ROLES = {
    IID_IUnknown: "fifo",
    IID_IVciFifo: "fifo",
    IID_IVciFifo2: "fifo",
    IID_IFifoReader: "reader",
    IID_IFifoWriter: "writer",
}


class Source(Protocol):
    """What IVciFifo2 needs from a FIFO."""

    @property
    def ring(self) -> Ring: ...
    @property
    def entry_size(self) -> int: ...
    def check(self) -> None: ...
    def reset(self) -> None: ...
    def close(self) -> None: ...
    def sibling(self, iid: UUID) -> Unknown: ...


class VciFifo(Unknown):
    """IVciFifo: the size and the fill level of a FIFO. Counts are numbers of elements. Source: manual 6.4.1."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_IVciFifo})

    def __init__(self, fifo: Source) -> None:
        super().__init__()
        self._fifo = fifo
        self._ring = fifo.ring

    @vci_call
    def query_interface(self, iid: UUID) -> Any:
        """QueryInterface: this or another interface of the FIFO.

        Raises VciAccessDenied if IID_IFifoReader or IID_IFifoWriter is open already, or if a channel or monitor uses
        that end itself, and VciNoInterface for an interface that no FIFO has.
        """
        return super().query_interface(iid) if iid in self.interfaces else self._fifo.sibling(iid)

    @vci_call
    def get_capacity(self) -> int:
        """GetCapacity: the number of elements that the FIFO can contain."""
        return self._ring.capacity

    @vci_call
    def get_entry_size(self) -> int:
        """GetEntrySize: the number of bytes of an element."""
        return self._fifo.entry_size

    @vci_call
    def get_free_count(self) -> int:
        """GetFreeCount: the number of free elements."""
        return self._ring.free()

    @vci_call
    def get_fill_count(self) -> int:
        """GetFillCount: the number of elements that wait to be read."""
        return self._ring.fill()

    @vci_call
    def get_fill_level(self) -> int:
        """GetFillLevel: the load of the FIFO, 0 to 100 percent."""
        return self._ring.fill() * 100 // self._ring.capacity

    def _check(self) -> None:
        super()._check()
        self._fifo.check()

    def _close(self) -> None:
        self._fifo.close()


class VciFifo2(VciFifo):
    """IVciFifo2: IVciFifo, and Reset, which empties the FIFO. Source: manual 6.4.1."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_IVciFifo, IID_IVciFifo2})

    @vci_call
    def reset(self) -> None:
        """Reset: discard all elements; raises VciAccessDenied while a reader or writer is open.

        In the FIFOs of channels and monitors one end is always open.
        """
        with meaning(VCI_E_ACCESSDENIED, WrongState):
            self._fifo.reset()


class OwnFifo:
    """A FIFO of the hub that a program made with `create_fifo` (Source)."""

    def __init__(self, hub: Hub, fifo: Fifo) -> None:
        self._hub = hub
        self._fifo = fifo
        self.ring = fifo.end_of_ring.ring
        self.entry_size = self.ring.record_size
        self.check = fifo.check
        self.reset = fifo.reset
        self.close = fifo.close

    def sibling(self, iid: UUID) -> Unknown:
        return open_fifo(self._hub, self._fifo.id, iid)


class QueueFifo:
    """A FIFO of a channel or monitor, which uses one end of it itself (Source).

    `open_end` opens the other end, whose interface is `own`. `gone` raises VciError if the FIFO no longer exists.
    """

    def __init__(
        self,
        end: RingEnd,
        form: Elements[Any],
        own: UUID,
        open_end: Callable[[], Unknown],
        gone: Callable[[], None],
    ) -> None:
        self._name = end.lease.name
        self._own = own
        self._open_end = open_end
        self.check = gone
        self.ring = end.ring
        self.entry_size = form.size

    def reset(self) -> None:
        raise VciError.of(VCI_E_ACCESSDENIED, f"{self._name} uses one end of this FIFO itself")

    def close(self) -> None:
        """Does nothing, since the FIFO belongs to the channel or monitor."""

    def sibling(self, iid: UUID) -> Unknown:
        role = role_of(iid)
        if role == "fifo":
            return VciFifo2(self)
        if iid != self._own:
            raise VciError.of(VCI_E_ACCESSDENIED, f"{self._name} uses the {role} of this FIFO itself")
        return self._open_end()


def role_of(iid: UUID) -> str:
    """The hub's name for an interface of a FIFO; raises VciNoInterface for another interface."""
    role = _ROLES.get(iid)
    if role is None:
        raise VciError.of(VCI_E_NOINTERFACE, f"a FIFO has no {interface_name(iid)}")
    return role


def open_fifo(hub: Hub, vciid: int, iid: UUID) -> VciFifo2 | FifoReader[bytes] | FifoWriter[bytes]:
    """An interface of an existing FIFO. Raises what `access_fifo` raises."""
    role = role_of(iid)
    with meaning(VCI_E_OBJECTID_NOT_FOUND, NoSuchBoard):
        fifo = hub.open_fifo(vciid, role)
    if role == "fifo":
        return VciFifo2(OwnFifo(hub, fifo))
    kind: Any = FifoReader if role == "reader" else FifoWriter
    form, sibling = Plain(fifo.element_size), partial(open_fifo, hub, fifo.id)
    end: FifoReader[bytes] | FifoWriter[bytes] = kind(fifo.end_of_ring, form, fifo.close, sibling)
    return end
