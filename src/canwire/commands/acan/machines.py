"""Machines that CANTERM and WCT talk to: their identifiers, and how they set the controller up.

A message for machine mmm has the 11-bit identifier 00001001mmm; 000 is for all. The hardware filter looks at mmm
alone, so that other programs of the same machine may give the other bits a meaning.
Source: INduCAN104 manual, trace of "CAN Spy", "Messages identification".
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire import BadValue, InUse, acan, conflicts_on
from canwire.commands.acan.words import CLOCK_KHZ, RATE_KBPS

if TYPE_CHECKING:
    from canwire.acan import Driver, HardConfig

FIELD = acan.MachineField()  # mmm, as the manual's example has it
_BASE = 0b00001001_000
_STANDARD_BITS = acan.acan_word(0x7FF)


def identifier(machine: int) -> int:
    """The identifier of messages for that machine, 1 to 7, or for all machines: 0."""
    return _BASE | machine


def config_of(machine: int, clock_khz: int = CLOCK_KHZ, rate_kbps: int = RATE_KBPS) -> HardConfig:
    """The controller lets in what is for this machine, 1 to 7, and what is for all. Raises BadTiming, BadValue."""
    return acan.HardConfig(
        machine_id=FIELD.word(machine),
        machine_mask=FIELD.mask,
        broadcast_id=FIELD.word(acan.BROADCAST),
        broadcast_mask=FIELD.mask,
        clock_khz=clock_khz,
        rate_kbps=rate_kbps,
    )


def configured_machine(config: HardConfig | None) -> int:
    """The number that the machine has by its configuration; raises BadValue if it has none of this format."""
    if config is None:
        raise BadValue("local MID 0: this machine has no number yet; give 1 to 7")
    number = FIELD.destination(config.machine_id)
    if config.machine_mask & _STANDARD_BITS != FIELD.mask or number == acan.BROADCAST:
        raise BadValue(
            f"local MID 0: this machine's number ({config.machine_id:#x}, mask {config.machine_mask:#x}) "
            "is none of three bits at the end of an 11-bit identifier; give 1 to 7"
        )
    return number


def configure(driver: Driver, config: HardConfig) -> None:
    """Set the controller up; off the bus afterwards. Raises InUse if a spy holds the filter, BadTiming, BadValue."""
    try:
        driver.configure(config)
    except InUse as error:
        raise InUse(f"cannot install its own message filter: {error}; start CANSPY last") from None


def set_up(
    driver: Driver, local: int, clock_khz: int = CLOCK_KHZ, rate_kbps: int = RATE_KBPS, *, force: bool = False
) -> tuple[int, str]:
    """Have the controller on the bus; this terminal's machine number, and a remark or "".

    An initialised controller is left as it is unless `force`. `local` 0: the machine's configured number.
    Raises BadValue, BadTiming, InUse.
    """
    before = driver.config()
    machine = local or configured_machine(before)
    remark = ""
    if force or before is None:
        configure(driver, config_of(machine, clock_khz, rate_kbps))
    elif not before.accepts(identifier(machine)):
        remark = (
            f"the controller was set up before and accepts nothing for machine {machine}; /I sets it up again"
        )
    elif not before.accepts(identifier(acan.BROADCAST)):
        remark = (
            "the controller was set up before and accepts no message for all machines; /I sets it up again"
        )
    driver.bus_on()
    return machine, remark


def rate_remarks(driver: Driver) -> list[str]:
    """Remarks on other controllers of its bus at other rates: their lines, and the programs that set them."""
    return [f"! {conflict}" for conflict in conflicts_on(driver.hub, driver.bus)] if driver.bus else []
