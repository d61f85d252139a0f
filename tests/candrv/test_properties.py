"""What the controllers can. Source: CANDRV manual, 8.13 to 8.16, 8.22, 8.23; rulings.md 18."""

from __future__ import annotations

import pytest

from canwire import BadTiming, BadValue, candrv
from canwire.candrv import CanMode, ChipsetFlags, Command, Controller, controller_of
from canwire.candrv.properties import CONTROLLERS, MCP2515, RATES, SJA1000

A, B = CanMode.CAN_2_0_A, CanMode.CAN_2_0_B
both = pytest.mark.parametrize("controller", [MCP2515, SJA1000], ids=lambda one: one.name)
modes = pytest.mark.parametrize("mode", [A, B])


@pytest.mark.parametrize(
    ("kind", "name"),
    [("picocom1", "MCP2515"), ("picocom2", "MCP2515"), ("picocom4", "MCP2515"), ("picomod3", "MCP2515"),
     ("netdcu", "SJA1000")],
)  # fmt: skip
def test_boards(kind: str, name: str) -> None:
    assert controller_of(kind).name == name
    assert len(CONTROLLERS) == 5


def test_other_boards() -> None:
    with pytest.raises(BadValue, match="usb-to-can: CANDRV drives picocom1"):
        controller_of("usb-to-can")


@pytest.mark.conforms("FS-50")
@both
@modes
def test_properties(controller: Controller, mode: CanMode) -> None:
    told = controller.properties(mode)
    assert told.version == 0x0206
    assert told.device_name == f"F&S CAN driver V2.06, {controller.name}"
    assert (told.min, told.max) == (5000, 1_000_000)
    assert told.commands[: told.nCommands] == tuple(map(int, Command))
    assert told.nBaudrates == len(RATES) <= candrv.CANBUS_NUMBER_OF_CONSTANT_BAUDRATES
    assert told.baudrates[: told.nBaudrates] == RATES
    assert not any(told.commands[told.nCommands :] + told.baudrates[told.nBaudrates :])
    assert told.nRegisters == 128
    assert candrv.CAN_PROPERTIES.unpack(told.pack()) == told


@pytest.mark.conforms("FS-50")
@both
def test_properties_change_with_the_mode(controller: Controller) -> None:
    basic, full = controller.properties(A), controller.properties(B)
    assert basic.chipset_flags == ChipsetFlags.CAN_2_0_A | ChipsetFlags.CAN_2_0_B
    assert full.chipset_flags == basic.chipset_flags | ChipsetFlags.EXT_FRAME


@pytest.mark.conforms("FS-51")
@both
def test_commands_by_number(controller: Controller) -> None:
    for number in range(-1, 12):
        if number in set(Command):
            assert controller.command(number) is Command(number)
        else:
            with pytest.raises(BadValue, match=f"command {number}: {controller.name} has 1 ENTER"):
                controller.command(number)


@pytest.mark.conforms("FS-43")
@both
def test_rates_by_constant(controller: Controller) -> None:
    for index, rate in enumerate(controller.rates):
        assert controller.rate_of_index(index) == rate
        assert controller.index_of_rate(rate) == index
    for rate in (5000, 333_333, 999_999, 0):
        assert controller.index_of_rate(rate) == 0xFFFFFFFF
    for index in (-1, len(RATES), 0xFFFFFFFF):
        with pytest.raises(BadTiming, match="baud rate constant"):
            controller.rate_of_index(index)
    assert list(controller.rates) == sorted(set(controller.rates))


@pytest.mark.conforms("FS-43")
@both
def test_every_rate_of_the_table_works(controller: Controller) -> None:
    for rate in (*controller.rates, controller.min, controller.max):
        timing = controller.timing(rate)
        assert timing.exact_bit_rate == rate
        assert timing.quanta <= 25


@pytest.mark.conforms("FS-42")
@both
@pytest.mark.parametrize("rate", [0, 4999, 1_000_001, 0xFFFFFFFF])
def test_rates_out_of_range(controller: Controller, rate: int) -> None:
    with pytest.raises(BadTiming, match=f"{controller.name} has 5000 to 1000000"):
        controller.timing(rate)


@pytest.mark.conforms("FS-42")
@both
@pytest.mark.parametrize("rate", [333_000, 700_000, 999_999, 5001])
def test_rates_the_clock_cannot_make(controller: Controller, rate: int) -> None:
    with pytest.raises(BadTiming, match=str(rate)):
        controller.timing(rate)
