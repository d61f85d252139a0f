"""The lab: buses on one timeline."""

from __future__ import annotations

from collections.abc import Sequence
from types import NoneType, TracebackType
from typing import TYPE_CHECKING, Any, Never

from canwire.errors import BadValue
from canwire.lab.bus import BenchBus
from canwire.lab.can.bus import LabBus
from canwire.lab.lin.bus import LabLinBus
from canwire.lab.time import LabTime
from canwire.values.arguments import unknown_argument
from canwire.values.checks import finite, instance
from canwire.values.mistakes.names import answers_wrong_names
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.limits import check_data_rate, checked_rate

if TYPE_CHECKING:
    from canwire.hub.handles.hub import Hub
    from canwire.lab.hub import LabHub
    from canwire.lab.serving import Serving
    from canwire.threads.company import Company

CLOCK_HZ = 80_000_000
_STALL_NS = 1_000_000_000
_LONGEST_M = 1e6
_LONGEST_DELAY_NS = 1e6


@answers_wrong_names
class Lab(LabTime):
    """Any number of buses on one timeline.

    `time` is "virtual" (jumps from one event to the next, as fast as possible) or "real" (follows the wall
    clock, in a separate thread). All random values come from `seed`: the same script gives the same
    bytes.

    >>> with Lab() as lab:
    ...     bus = lab.can_bus("can0", bit_rate=500_000)
    ...     a, b = bus.node("engine"), bus.node("tester")
    ...     a.send(Frame(0x123, b"\\x11\\x22"))
    ...     lab.run_until_idle()
    ...     b.receive()
    Frame(0x123, bytes.fromhex("1122"), timestamp_ns=124000)
    """

    def __init__(self, *, time: str = "virtual", seed: int = 0, **unknown: Never) -> None:
        if unknown:
            raise unknown_argument("Lab()", unknown, Lab.__init__)
        super().__init__(time)
        self.seed = seed
        self.buses: dict[str, LabBus] = {}
        self.lin_buses: dict[str, LabLinBus] = {}
        self._serving: Serving | None = None
        self._hub: LabHub | None = None

    def can_bus(
        self,
        name: str = "can0",
        *,
        bit_rate: int = 500_000,
        data_bit_rate: int | None = None,
        timing: BitTiming | None = None,
        data_timing: BitTiming | None = None,
        iso_fd: bool = True,
        length_m: float = 0.0,
        node_delay_ns: float = 0.0,
        **unknown: Never,
    ) -> LabBus:
        """A new bus. Rates in bit/s; `data_bit_rate` (or `data_timing`) makes it a CAN FD bus.

        Exact timings override rates. `length_m` is the length of the cable, `node_delay_ns` the delay that an
        isolated node adds in each direction (75 for one 6N137 opto-coupler). Raises BadTiming for rates that the 80 MHz
        clock of the lab's controllers cannot make, BadValue for a name that is taken.
        """
        if unknown:
            raise unknown_argument("can_bus()", unknown, Lab.can_bus)
        self._check_new(name)
        if data_bit_rate is not None:
            checked_rate("data_bit_rate", data_bit_rate)
        for part, wanted in (("timing", timing), ("data_timing", data_timing)):
            instance(part, wanted, BitTiming, NoneType)
        length_m = finite("length_m", length_m, 0, _LONGEST_M)
        node_delay_ns = finite("node_delay_ns", node_delay_ns, 0, _LONGEST_DELAY_NS)
        nominal = timing or BitTiming.for_bit_rate(bit_rate, clock_hz=CLOCK_HZ)
        data = data_timing
        if data is None and data_bit_rate is not None:
            data = BitTiming.for_bit_rate(data_bit_rate, clock_hz=CLOCK_HZ)
        if data is not None:
            check_data_rate(nominal.bit_rate, data.bit_rate)
        with self.touch():
            bus = LabBus(self, name, nominal, data, iso_fd, length_m, node_delay_ns, self.seed)
        self.buses[name] = bus
        self._made(bus)
        return bus

    def lin_bus(
        self,
        name: str = "lin0",
        *,
        bit_rate: int = 19_200,
        sleep_after: float | None = 4.0,
        **unknown: Never,
    ) -> LabLinBus:
        """A new LIN bus at 1,000 to 20,000 bit/s; `master` and `slave` put nodes on it.

        Its nodes go to sleep after `sleep_after` seconds without an edge (None: never). Raises BadValue.
        """
        if unknown:
            raise unknown_argument("lin_bus()", unknown, Lab.lin_bus)
        self._check_new(name)
        with self.touch():
            bus = LabLinBus(self, name, bit_rate, sleep_after)
        self.lin_buses[name] = bus
        self._made(bus)
        return bus

    def serve(self, address: str | None = None, *, boards: Sequence[str] = ("usb-to-can-fd",)) -> str:
        """Share the present buses with other programs until the lab is closed; returns the address of the socket.

        Programs connect with `canwire.connect(address)` (None: the address of this user's default hub). They find
        boards of the kinds `boards`, with lines on the first CAN and LIN bus of the lab, and can plug in more. Time
        must be "real". A callback of a script must not call this hub: it would block. Raises BadValue, NoSuchBoard,
        and HubError if another hub uses the address.
        """
        from canwire.lab.serving import Serving  # what the lab alone needs no messages for

        self.check_open()
        if self.pacer is None:
            raise BadValue('a lab in virtual time waits for nobody else: Lab(time="real") can be served')
        if self._serving is not None:
            raise BadValue(f"this lab is served on {self._serving.address} already")
        self._serving = Serving(self.pacer, self.timeline, self.buses, self.lin_buses, address, boards)
        return self._serving.address

    def hub(self) -> Hub:
        """A hub on the buses and in the time of this lab, for code of this process that uses other interfaces.

        `can.Bus(interface="canwire", channel=lab.buses["can0"])` uses it automatically. It has no boards until some
        are plugged in: `vci.initialize(lab.hub())` after `lab.hub().plug("usb-to-can-fd", buses=("can0", "can0", ""))`.
        """
        from canwire.lab.hub import LabHub  # what the lab alone needs no messages for

        self.check_open()
        if self._hub is None:
            self._hub = LabHub(self.timeline, self.held, self.pacer)
        self._hub.add({**self.buses, **self.lin_buses})
        self._hub.handle.company = self._company
        return self._hub.handle

    @property
    def company(self) -> Company | None:
        """The threads of this program that share this time (canwire.in_time)."""
        return self._company

    @company.setter
    def company(self, company: Company | None) -> None:
        self._company = company
        if self._hub is not None:
            self._hub.handle.company = company

    def kick(self) -> None:
        if self._hub is not None:
            self._hub.kick()

    def __enter__(self) -> Lab:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        names = ", ".join([*self.buses, *self.lin_buses]) or "no bus"
        kind = "virtual" if self.pacer is None else "real"
        return f"<lab in {kind} time, {'closed' if self.closed else f'{self.now_ns} ns'}: {names}>"

    def leave_to_parent(self) -> None:
        super().leave_to_parent()
        buses: tuple[BenchBus[Any, Any, Any], ...] = (*self.buses.values(), *self.lin_buses.values())
        for bus in buses:
            for node in bus.nodes.values():
                node.leave_to_parent()

    def _made(self, bus: BenchBus[Any, Any, Any]) -> None:
        """Called with each new bus; subclasses override it."""

    def _stalled(self) -> str | None:
        for bus in self.buses.values():
            trouble = bus.stalled(_STALL_NS)
            if trouble is not None:
                return trouble
        return None

    def _leave(self) -> None:
        if self._serving is not None:
            self._serving.close()
        if self._hub is not None:
            self._hub.close()
        for bus in self.buses.values():
            bus.close()
        for lin_bus in self.lin_buses.values():
            lin_bus.close()

    def _check_new(self, name: str) -> None:
        self.check_open()
        instance("name", name, str)
        if name in self.buses or name in self.lin_buses:
            raise BadValue(f"there is a bus {name!r} already")
