"""The functions of ACAN.H, with the names and return values of C, over one driver per process.

No function raises: a failure returns FALSE, 0 or -1 as in C, and `last_error()` returns its cause. A star import
provides all of ACAN.H: these functions, the constants, the structures and the types.
Source: INduCAN104 manual, "Programming interface"; rulings.md 24.
"""

# ruff: noqa: N802, N803 - functions and parameters have the manual's names
from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from canwire import BadValue, CanwireError, NotInitialised, WrongState
from canwire.acan import c_types as _types
from canwire.acan import constants as _constants
from canwire.acan import structures as _structures
from canwire.acan.c_types import *  # noqa: F403
from canwire.acan.constants import *  # noqa: F403
from canwire.acan.constants import BusState
from canwire.acan.driver import Driver, open_driver
from canwire.acan.hard_config import HardConfig
from canwire.acan.messages import frame_of
from canwire.acan.mirrored_block import MirroredBlock
from canwire.acan.structures import *  # noqa: F403
from canwire.acan.structures import ACANHI, ACANMB, ACANTB

if TYPE_CHECKING:
    from canwire import Hub

__all__ = [  # noqa: RUF022 - in the manual's order
    "ACAN_Init",
    "ACAN_GetDriverVersion",
    "ACAN_GetInitStatus",
    "ACAN_SetHardConfig",
    "ACAN_GetHardConfig",
    "ACAN_BusControl",
    "ACAN_Register",
    "ACAN_AckEvent",
    "ACAN_AckEventCheck",
    "ACAN_Deregister",
    "ACAN_SendMessage",
    "ACAN_RetrieveMessages",
    "ACAN_AllocFixedMemory",
    "ACAN_FreeFixedMemory",
    "ACAN_Exit",
    "last_error",
    "use",
]
__all__ += sorted(
    name
    for module in (_types, _constants, _structures)
    for name in vars(module)
    if name.isupper() and name[0] != "_" and name not in {"ONE_BYTE", *__all__}  # ACAN.H has no such name
)

P = ParamSpec("P")
T = TypeVar("T")


class _Library:
    """What one process has open: a hub, a driver, registered Task Blocks and allocated memory."""

    def __init__(self) -> None:
        self.hub: Hub | None = None
        self.driver: Driver | None = None
        self.blocks: dict[int, MirroredBlock] = {}  # by the identity of their ACANTB
        self.memory: dict[int, bytearray] = {}
        self.error: CanwireError | None = None

    def opened(self) -> Driver:
        """The open driver; raises NotInitialised before ACAN_Init."""
        if self.driver is None:
            raise NotInitialised("call ACAN_Init first")
        return self.driver

    def registered(self, fields: ACANTB) -> MirroredBlock:
        """The driver's block for this Task Block; raises WrongState if it is not registered."""
        block = self.blocks.get(id(fields))
        if block is None:
            raise WrongState("the Task Block is not registered")
        return block

    def close(self) -> None:
        driver, self.driver = self.driver, None
        self.blocks.clear()
        self.memory.clear()
        if driver is not None:
            driver.close()


_LIBRARY = _Library()


def _answering(failure: T) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Makes a function return `failure` where it would raise a CanwireError, which `last_error` then returns."""

    def wrap(call: Callable[P, T]) -> Callable[P, T]:
        @wraps(call)
        def answer(*args: P.args, **kwargs: P.kwargs) -> T:
            try:
                return call(*args, **kwargs)
            except CanwireError as error:
                _LIBRARY.error = error
                return failure

        return answer

    return wrap


def last_error() -> CanwireError | None:
    """The error of the last function that failed; None if none has failed since the last `use`."""
    return _LIBRARY.error


def use(hub: Hub | None) -> None:
    """Close what is open, and have the next ACAN_Init open its driver on `hub`; None: on `canwire.connect()`."""
    ACAN_Exit()
    _LIBRARY.hub, _LIBRARY.error = hub, None


@_answering(0)
def ACAN_Init() -> int:
    """Open the driver; returns its version, 0xMMmm, or 0 if it is not operational. A second call changes nothing."""
    if _LIBRARY.driver is not None and _LIBRARY.driver.lost:
        _LIBRARY.close()
    if _LIBRARY.driver is None:
        _LIBRARY.driver = open_driver(_LIBRARY.hub)
    return _version(_LIBRARY.driver)


@_answering(0)
def ACAN_GetDriverVersion() -> int:
    """The driver's version, 0xMMmm; 0 if the driver is not operational, or before ACAN_Init."""
    driver = _LIBRARY.opened()
    return 0 if driver.lost else _version(driver)


@_answering(0)
def ACAN_GetInitStatus() -> int:
    """0xSSTT: SS is 1 once the hardware is initialised, TT is the type of controller, 0 for the SJA1000."""
    driver = _LIBRARY.opened()
    return int(driver.initialised) << 8 | driver.controller


@_answering(False)
def ACAN_SetHardConfig(lpHI: ACANHI) -> bool:
    """Initialise the hardware for all programs; it is off the bus afterwards. FALSE if a field is invalid."""
    _LIBRARY.opened().configure(HardConfig.from_hi(_given(lpHI, ACANHI)))
    return True


@_answering(False)
def ACAN_GetHardConfig(lpHI: ACANHI) -> bool:
    """Fill in the structure; FALSE if the hardware is not initialised."""
    config, hi = _LIBRARY.opened().config(), _given(lpHI, ACANHI)
    if config is None:
        raise NotInitialised("the hardware is not initialised")
    hi.assign(config.to_hi())
    return True


@_answering(0)
def ACAN_BusControl(bsNewState: BusState | int) -> int:
    """Take the controller on or off the bus; returns 0xOONN, the old and the new state, the same if that failed."""
    driver = _LIBRARY.opened()
    now = driver.on_bus
    try:
        before = driver.bus_on() if bsNewState else driver.bus_off()
    except CanwireError as error:
        _LIBRARY.error = error
        return now << 8 | now
    return before << 8 | bool(bsNewState)


@_answering(False)
def ACAN_Register(lpTB: ACANTB) -> bool:
    """Register a Task Block; FALSE if a field is invalid, or if the block is registered already."""
    if id(lpTB) in _LIBRARY.blocks:
        raise WrongState("the Task Block is registered already")
    block = MirroredBlock(_given(lpTB, ACANTB))
    _LIBRARY.blocks[id(lpTB)] = block
    try:
        _LIBRARY.opened().register(block)
    except BaseException:
        del _LIBRARY.blocks[id(lpTB)]
        raise
    return True


@_answering(0)
def ACAN_AckEvent(lpTB: ACANTB) -> int:
    """Return the block's wStatus and set it to 0; 0 for a block that is not registered."""
    block = _LIBRARY.registered(lpTB)
    _LIBRARY.opened().pump()
    return int(block.acknowledge())


@_answering(0)
def ACAN_AckEventCheck(lpTB: ACANTB) -> int:
    """The same as ACAN_AckEvent, which in canwire checks its block as well: 0 if the block is not registered."""
    return ACAN_AckEvent(lpTB)


@_answering(False)
def ACAN_Deregister(lpTB: ACANTB) -> bool:
    """Deregister a Task Block; FALSE if it is not registered."""
    block = _LIBRARY.registered(lpTB)
    del _LIBRARY.blocks[id(lpTB)]
    _LIBRARY.opened().deregister(block)
    return True


@_answering(False)
def ACAN_SendMessage(lpMsg: ACANMB, bPrio: int) -> bool:
    """Send or queue a message; priority 0 is sent first, 255 last. FALSE without a free buffer or if invalid."""
    _LIBRARY.opened().send(frame_of(_given(lpMsg, ACANMB)), bPrio)
    return True


@_answering(-1)
def ACAN_RetrieveMessages(lpTB: ACANTB) -> int:
    """Move up to wCount messages to lpBuf, the oldest first; returns how many, -1 for an invalid block or buffer."""
    block = _LIBRARY.registered(lpTB)
    _LIBRARY.opened().pump()
    return block.retrieve_into(lpTB.lpBuf, lpTB.wCount)


def ACAN_AllocFixedMemory(nBytes: int) -> bytearray | None:
    """A bytearray of `nBytes` zeros; None if `nBytes` is no positive whole number or too large."""
    if not isinstance(nBytes, int) or nBytes <= 0:
        return None
    try:
        block = bytearray(nBytes)
    except (MemoryError, OverflowError):
        return None
    _LIBRARY.memory[id(block)] = block
    return block


def ACAN_FreeFixedMemory(lpAlloc: Any, nBytes: int) -> bool:
    """Free memory once; FALSE unless ACAN_AllocFixedMemory returned it, with this size."""
    block = _LIBRARY.memory.get(id(lpAlloc))
    if block is None or len(block) != nBytes:
        return False
    del _LIBRARY.memory[id(lpAlloc)]
    return True


def ACAN_Exit() -> None:
    """Release everything: Task Blocks, memory, the connection to the hub. The controller stays as it is."""
    _LIBRARY.close()


def _given(structure: T, kind: type[T]) -> T:
    """The structure; raises BadValue for NULL, and for an object of another type."""
    if not isinstance(structure, kind):
        raise BadValue(f"{structure!r:.40} is not an {kind.__name__}")
    return structure


def _version(driver: Driver) -> int:
    major, minor = driver.version
    return major << 8 | minor
