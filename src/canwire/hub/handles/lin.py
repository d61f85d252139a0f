"""A client's leases on a LIN line: its control, and monitors that receive."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from canwire.boards.lin.modes import LinLineStatus, LinMode, LinMonitorMode, LinMonitorStatus
from canwire.boards.lin.monitor import message_of_record
from canwire.errors import NotInitialised, Unsupported
from canwire.hub.handles.ends import RingEnd
from canwire.hub.handles.lease import Lease
from canwire.hub.protocol import messages as m
from canwire.platform import EventDescriptor, close_descriptors
from canwire.ring import Ring
from canwire.values.checks import instance, nanoseconds, octets, whole
from canwire.values.lin.configuration import LinNodeAttributes
from canwire.values.lin.record import record_of_lin_frame

if TYPE_CHECKING:
    from canwire.hub.handles.client import Client
    from canwire.hub.protocol.lin_messages import LinConfiguration
    from canwire.values.lin.event import LinEvent
    from canwire.values.lin.frame import LinFrame
    from canwire.values.lin.schedule import LinSchedule


class LinControl(Lease):
    """The one lease that may configure a LIN line and send on it."""

    def __init__(self, hub: Client, handle: int, board: int, line: int) -> None:
        super().__init__(hub, handle, f"control of LIN line {line}")
        self.board = board
        self.line = line

    def initialise(self, mode: LinMode) -> None:
        """Reset the line and set it up; it is stopped then. Raises BadValue, Unsupported."""
        self.ask(m.InitialiseLin(self.handle, mode))

    def start(self) -> None:
        """Take part in the bus; raises NotInitialised."""
        self.ask(m.Start(self.handle))

    def stop(self) -> None:
        """Leave the bus once a frame on the wire is over; the response table stays."""
        self.ask(m.Stop(self.handle))

    def reset(self) -> None:
        """Leave the bus immediately, and discard settings and response table."""
        self.ask(m.Reset(self.handle))

    def send(self, frame: LinFrame) -> None:
        """Master only: put a frame, or its header alone, on the bus as soon as it is free.

        Raises WrongState (a slave, or not started), NotInitialised, and Busy while the previous one is not over.
        """
        self.ask(m.WriteLin(self.handle, record_of_lin_frame(frame), True))

    def respond(self, frame: LinFrame) -> None:
        """Answer this header with this data from now on; at any time once the line is initialised."""
        self.ask(m.WriteLin(self.handle, record_of_lin_frame(frame), False))

    def wake_up(self) -> None:
        """Send a wake-up pulse, as master or slave."""
        self.ask(m.WakeLin(self.handle, False))

    def go_to_sleep(self) -> None:
        """Master only: send the go-to-sleep command."""
        self.ask(m.WakeLin(self.handle, True))

    def run_schedule(self, schedule: LinSchedule, rounds: int = 0) -> None:
        """Master only: run this table in the hub `rounds` times (0: no limit), instead of the running one."""
        self.ask(m.RunSchedule(self.handle, schedule, rounds))

    def stop_schedule(self) -> None:
        """End the running table, if there is one."""
        self.ask(m.RunSchedule(self.handle, None, 0))

    def request(self, nad: int, payload: bytes, *, within: float = 1.0) -> bytes:
        """Master only: send a request (SID and data, 1 to 4095 bytes) to this NAD; returns the payload that answers.

        b"" for a functional request (NAD 0x7E). A negative response is a payload too: 7F, the SID, a code. The hub
        sends the request between other frames of the line. Raises NotReceived after `within` seconds of bus time,
        WrongState (a slave, or not started), NotInitialised, and Busy while another request is not over.
        """
        whole("nad", nad, 0, 0xFF)
        wanted = m.RequestLin(self.handle, nad, octets("payload", payload), nanoseconds("within", within))
        return bytes(self.ask(wanted).value)

    def configure(self, attributes: LinNodeAttributes) -> None:
        """Slave only: answer node configuration and identification from now on, in the hub, to any master.

        The frames of `attributes` are responses of the line (`respond`), which move to the identifiers that a master
        assigns. It ends when the line is next set up or reset. Raises WrongState, and Unsupported for attributes with
        functions (`data_dump`, `service`), which a hub cannot call.
        """
        instance("attributes", attributes, LinNodeAttributes)
        if attributes.data_dump is not None or attributes.service is not None:
            raise Unsupported(f"{self.name}: a hub cannot call data_dump and service; leave them out")
        self.ask(
            m.ConfigureLin(
                self.handle,
                attributes.product,
                attributes.nad,
                dict(attributes.frames),
                attributes.serial,
                dict(attributes.identifiers),
                attributes.message_ids,
                attributes.p2_ns,
                attributes.n_as_ns,
                attributes.n_cr_ns,
            )
        )

    def configuration(self) -> LinConfiguration:
        """A configured slave's `nad`, and `frames`: its identifiers by index (None: unassigned). Raises WrongState."""
        state: LinConfiguration = self.ask(m.GetLinConfiguration(self.handle, False))
        return state

    def power_up(self) -> None:
        """Simulate a return of power: a configured slave uses the NAD and identifiers saved last. Raises WrongState."""
        self.ask(m.GetLinConfiguration(self.handle, True))

    def status(self) -> m.LinLineState:
        """The LinLineStatus in `status`, and the holders of leases on the line."""
        self.check()
        return self.hub.lin_status(self.board, self.line)


class Monitor(Lease):
    """One client's receive queue on a LIN line: `set_up` makes it, `activate` connects it."""

    def __init__(self, hub: Client, handle: int, board: int, line: int) -> None:
        super().__init__(hub, handle, f"monitor on LIN line {line}")
        self.board = board
        self.line = line
        self._reading: RingEnd | None = None
        self._swapping = threading.Lock()

    def set_up(self, mode: LinMonitorMode) -> None:
        """Make the queue, or replace it (its contents are discarded); the monitor is inactive then."""
        self.check()
        reply, (memory, *event) = self.hub.ask(m.SetUpMonitor(self.handle, mode))
        heard = EventDescriptor.adopt(*event)
        try:
            ring = Ring.over(memory, reply.receive, exact=True)
            lent = self.hub.lent(memory)
        finally:
            close_descriptors(memory)
        self._drop_end(RingEnd(self, ring, heard, reads=True, memory=lent))
        if self._closed:  # meanwhile, by another thread
            self._drop_end()

    @property
    def reading(self) -> RingEnd:
        """The receiving end; raises NotInitialised before `set_up`."""
        if self._reading is None:
            self.check()
            raise NotInitialised(f"{self.name}: set it up first")
        return self._reading

    def activate(self) -> LinLineStatus:
        """Start receiving messages whenever the line runs; returns the line's status at that moment.

        The result has no lateness of the hub.
        """
        status: LinLineStatus = self.ask(m.Activate(self.handle, True)).status
        return status

    def deactivate(self) -> None:
        """Stop receiving; messages in the queue stay."""
        self.ask(m.Activate(self.handle, False))

    def status(self) -> LinMonitorStatus:
        status: LinMonitorStatus = self.ask(m.GetMonitorStatus(self.handle)).status
        return status

    def receive(self, timeout: float | None = 0) -> LinFrame | LinEvent | None:
        """The oldest message, or None if none arrives within `timeout` seconds (None: no limit)."""
        end = self.reading
        if not end.ring.fill():
            self.check()
            if timeout != 0:
                end.wait(timeout)
        record = end.ring.take_bytes()
        end.touched()
        return None if record is None else message_of_record(record)

    def end(self, why: Exception) -> None:
        super().end(why)
        if self._reading is not None:
            self._reading.wake()

    def leave_to_parent(self, why: Exception) -> None:
        super().leave_to_parent(why)
        self._swapping = threading.Lock()  # the thread that may have held it is not here
        if self._reading is not None:
            self._reading.leave_to_parent()

    def close(self) -> None:
        super().close()
        self._drop_end()

    def _drop_end(self, reading: RingEnd | None = None) -> None:
        """Replace the present end by this one and close the present one; several threads may do that simultaneously."""
        with self._swapping:
            before, self._reading = self._reading, reading
        if before is not None:
            before.close()
