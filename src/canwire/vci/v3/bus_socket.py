"""The common part of all interfaces of a connector, and of control units, channels and monitors.

Source: VCI V3 .NET manual 4.1, 4.2.3 and 4.3.3; reference/vci.md section 7a.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, Generic, Protocol, TypeVar
from uuid import UUID

from canwire.vci.line_objects import QueueObject
from canwire.vci.structures.errors import VCI_E_NOT_INITIALIZED, VciAccessDenied, VciError
from canwire.vci.v3.disposable import net_call
from canwire.vci.v3.errors import ObjectDisposedException
from canwire.vci.v3.resource import BalResource

if TYPE_CHECKING:
    from canwire.vci import bal

Queue = TypeVar("Queue", bound=QueueObject[Any])


class Capabilities(Protocol):
    """The common part of CANCAPABILITIES and LINCAPABILITIES."""

    clock_freq: int
    tsc_divisor: int


class BusSocket(BalResource):
    """An open connector: V4's socket, and other objects of V4 that a subclass needs."""

    _iid: ClassVar[UUID]

    def __init__(self, access_layer: bal.BalObject, place: BalResource) -> None:
        """For IBalObject.OpenSocket."""
        super().__init__(place.bus_port, place.bus_type, place.bus_name)
        access_layer.add_ref()
        self._bal = self._hold(access_layer)
        try:
            self._hold(access_layer.keep_settings(self.bus_port))
            self._socket: Any = self._open(self._iid)
            self._open_more()
        except BaseException:
            self.dispose()
            raise

    def _open_more(self) -> None:
        """Open other objects of V4 that a subclass needs."""

    def _open(self, iid: UUID) -> Any:
        return self._hold(self._bal.open_socket(self.bus_port, iid))

    def _capabilities(self) -> Capabilities:
        """V4's capabilities structure, which is different for CAN and LIN."""
        raise NotImplementedError

    @property
    @net_call
    def clock_frequency(self) -> int:
        """ClockFrequency in Hz: the clock of the time stamps, and of all timers of a CAN line."""
        return self._capabilities().clock_freq

    @property
    @net_call
    def time_stamp_counter_divisor(self) -> int:
        """TimeStampCounterDivisor."""
        return self._capabilities().tsc_divisor


class ControlSocket(BusSocket):
    """A control unit: V4's `_control`."""

    _control_iid: ClassVar[UUID]
    _control: Any

    def _open_more(self) -> None:
        self._control = self._open(self._control_iid)

    @net_call
    def start_line(self) -> None:
        """StartLine: take part in the bus. Raises VciException if the line is not initialised."""
        self._control.start_line()

    @net_call
    def stop_line(self) -> None:
        """StopLine: leave the bus after the message that is being sent; filters, response table and FIFOs stay."""
        self._control.stop_line()

    @net_call
    def reset_line(self) -> None:
        """ResetLine: leave the bus immediately, also in the middle of a message; FIFOs stay.

        All filters of a CAN line are removed, the response table of a LIN line is emptied. Afterwards the line is
        offline with its previous settings, ready for `start_line`; in V4 it is not initialised.
        """
        settings = self._settings()
        self._control.reset_line()
        if settings is not None:
            self._control.init_line(settings)

    def _settings(self) -> Any:
        """The argument of V4's InitLine that gives the line its present settings; None if there is none."""
        raise NotImplementedError


class QueueSocket(BusSocket, Generic[Queue]):
    """A channel or monitor: V4's `_queue`, which is replaced if Initialize changes whether it is exclusive."""

    _may_come_late: ClassVar[bool] = False  # while an exclusive one is open, it opens without a queue

    def _open_more(self) -> None:
        self._queue: Queue
        self._exclusive: bool | None = None  # None while it has no queue
        self._initialized = False
        try:
            self._create(False)
        except VciAccessDenied:
            if not self._may_come_late:
                raise

    def _make(self, exclusive: bool) -> Queue:
        """A queue of V4, made by V4's socket."""
        raise NotImplementedError

    @net_call
    def activate(self) -> None:
        """Activate: messages move between the FIFOs and the line from now on, while the line is started."""
        self._initialized_queue().activate()

    @net_call
    def deactivate(self) -> None:
        """Deactivate: messages move no longer; the FIFOs keep theirs."""
        self._initialized_queue().deactivate()

    def _be_exclusive(self, exclusive: bool) -> None:
        if exclusive != self._exclusive:
            self._reopen(exclusive)

    def _initialized_queue(self) -> Queue:
        if not self._initialized:
            raise ObjectDisposedException(
                VCI_E_NOT_INITIALIZED, f"{type(self).__name__} on {self.bus_name}: call initialize first"
            )
        return self._queue

    def _reopen(self, exclusive: bool) -> None:
        """Replace the queue, since V4 fixes `exclusive` when it makes one; if that fails, restore the old kind."""
        before, self._exclusive = self._exclusive, None
        self._initialized = False
        if before is not None:
            self._drop(self._queue)
        try:
            self._create(exclusive)
        except VciError:
            if before is not None:
                self._create(before)
            raise

    def _create(self, exclusive: bool) -> None:
        self._queue = self._hold(self._make(exclusive))
        self._exclusive = exclusive
