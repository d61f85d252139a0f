"""ACAN.H's functions, under their own names and with their own answers, over one driver per process.

Nothing raises: a failure is FALSE, 0 or -1 as in C, and `last_error` says what it was. A star import brings all of
ACAN.H: these functions, its constants, structures and types.
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
    """What one process has open."""

    def __init__(self) -> None:
        self.hub: Hub | None = None
        self.driver: Driver | None = None
        self.blocks: dict[int, MirroredBlock] = {}  # by the identity of their ACANTB
        self.memory: dict[int, bytearray] = {}
        self.error: CanwireError | None = None

    def opened(self) -> Driver:
        """Raises NotInitialised before ACAN_Init."""
        if self.driver is None:
            raise NotInitialised("call ACAN_Init first")
        return self.driver

    def registered(self, fields: ACANTB) -> MirroredBlock:
        """Raises WrongState for a block that is not."""
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
    """An error is this answer."""

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
    """Why a function failed last; None if none ever has."""
    return _LIBRARY.error


def use(hub: Hub | None) -> None:
    """Where the next ACAN_Init finds its driver; None: `canwire.connect()`. What is open now is closed."""
    ACAN_Exit()
    _LIBRARY.hub, _LIBRARY.error = hub, None


@_answering(0)
def ACAN_Init() -> int:
    """The library's version, 0xMMmm; 0 if the driver is not operational. Repeated, it changes nothing."""
    if _LIBRARY.driver is not None and _LIBRARY.driver.lost:
        _LIBRARY.close()
    if _LIBRARY.driver is None:
        _LIBRARY.driver = open_driver(_LIBRARY.hub)
    return _version(_LIBRARY.driver)


@_answering(0)
def ACAN_GetDriverVersion() -> int:
    """0xMMmm; 0 if the driver is not operational, or before ACAN_Init."""
    driver = _LIBRARY.opened()
    return 0 if driver.lost else _version(driver)


@_answering(0)
def ACAN_GetInitStatus() -> int:
    """0xSSTT: SS 1 once the hardware is initialised, TT 0 for the SJA1000."""
    driver = _LIBRARY.opened()
    return int(driver.initialised) << 8 | driver.controller


@_answering(False)
def ACAN_SetHardConfig(lpHI: ACANHI) -> bool:
    """Initialise the hardware for every program; it is off the bus then. FALSE for fields that cannot be."""
    _LIBRARY.opened().configure(HardConfig.from_hi(_given(lpHI, ACANHI)))
    return True


@_answering(False)
def ACAN_GetHardConfig(lpHI: ACANHI) -> bool:
    """Fill the structure in; FALSE if the hardware is not initialised."""
    config, hi = _LIBRARY.opened().config(), _given(lpHI, ACANHI)
    if config is None:
        raise NotInitialised("the hardware is not initialised")
    hi.assign(config.to_hi())
    return True


@_answering(0)
def ACAN_BusControl(bsNewState: BusState | int) -> int:
    """Go on or off the bus; 0xOONN: the state before, the state now. Where that fails, both are the same."""
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
    """Register a Task Block. FALSE for fields that cannot be, and for one that is registered already."""
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
    """The block's wStatus, which is 0 then."""
    block = _LIBRARY.registered(lpTB)
    _LIBRARY.opened().pump()
    return int(block.acknowledge())


@_answering(0)
def ACAN_AckEventCheck(lpTB: ACANTB) -> int:
    """The same; 0 for a block that is not registered, which ACAN_AckEvent here answers, too."""
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
    """Send, or queue by priority: 0 first, 255 last. FALSE if no buffer is left, or for what cannot be sent."""
    _LIBRARY.opened().send(frame_of(_given(lpMsg, ACANMB)), bPrio)
    return True


@_answering(-1)
def ACAN_RetrieveMessages(lpTB: ACANTB) -> int:
    """Move up to wCount messages to lpBuf, the oldest first; how many, -1 for an invalid block or buffer."""
    block = _LIBRARY.registered(lpTB)
    _LIBRARY.opened().pump()
    return block.retrieve_into(lpTB.lpBuf, lpTB.wCount)


def ACAN_AllocFixedMemory(nBytes: int) -> bytearray | None:
    """So many zero bytes; None for a number that cannot be."""
    if not isinstance(nBytes, int) or nBytes <= 0:
        return None
    try:
        block = bytearray(nBytes)
    except (MemoryError, OverflowError):
        return None
    _LIBRARY.memory[id(block)] = block
    return block


def ACAN_FreeFixedMemory(lpAlloc: Any, nBytes: int) -> bool:
    """FALSE unless ACAN_AllocFixedMemory gave it, with this size; it can be freed once."""
    block = _LIBRARY.memory.get(id(lpAlloc))
    if block is None or len(block) != nBytes:
        return False
    del _LIBRARY.memory[id(lpAlloc)]
    return True


def ACAN_Exit() -> None:
    """Give back everything: blocks, memory, the connection. The controller stays as it is."""
    _LIBRARY.close()


def _given(structure: T, kind: type[T]) -> T:
    """Raises BadValue for NULL, and for a pointer to something else."""
    if not isinstance(structure, kind):
        raise BadValue(f"{structure!r:.40} is no {kind.__name__}")
    return structure


def _version(driver: Driver) -> int:
    major, minor = driver.version
    return major << 8 | minor
