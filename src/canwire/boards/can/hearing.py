"""What the programs of one interface receive on a line: the formats, error reports and filter that they set.

A line has one rate and mode, those of its controller. Everything else in a LineMode belongs to the channels of its
`kin`; a program of another kin that sets the line up again does not change it (rulings.md 45).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from canwire.boards.can.abilities import filter_of
from canwire.boards.can.channel import Channel
from canwire.boards.can.message_filter import MessageFilter
from canwire.boards.can.modes import LineMode
from canwire.boards.description import Feature, LineInfo
from canwire.values.acceptance import Acceptance
from canwire.values.acceptance_orders import sja1000_dual

_CODES, _MASKS = ("ACR0", "ACR1", "ACR2", "ACR3"), ("AMR0", "AMR1", "AMR2", "AMR3")


@dataclass(frozen=True, slots=True)
class Hearing:
    """`mode` is what a kin set last; if `filter` or `acceptance` is None, all frames pass it."""

    mode: LineMode
    filter: MessageFilter | None = None
    acceptance: Acceptance | None = None

    def give(self, channel: Channel) -> None:
        """Apply these settings to a channel from now on."""
        channel.standard, channel.extended = self.mode.standard, self.mode.extended
        channel.hears_errors = self.mode.error_frames
        channel.line_filter = self.filter
        channel.set_acceptance(self.acceptance)

    def seen(self, mode: LineMode) -> LineMode:
        """The line's mode with the settings of this kin."""
        own = self.mode
        return replace(
            mode,
            standard=own.standard,
            extended=own.extended,
            error_frames=own.error_frames,
            standard_filter=own.standard_filter,
            extended_filter=own.extended_filter,
            registers=tuple({**dict(mode.registers), **_acceptance_registers(own)}.items()),
            note=own.note,
        )


def hearing_of(mode: LineMode) -> Hearing:
    """What programs of this mode's kin receive on a line that was set up with it. Raises BadFilter."""
    registers = _acceptance_registers(mode)
    acceptance = None
    if mode.kin and registers:
        code = bytes(registers.get(name, 0) for name in _CODES)
        acceptance = sja1000_dual(code, bytes(registers.get(name, 0xFF) for name in _MASKS))
    return Hearing(mode, filter_of(mode), acceptance)


def unasked(info: LineInfo) -> Hearing:
    """What programs of a kin receive that has set nothing on the line: everything that the board can report."""
    can = info.capabilities.can
    both = can(Feature.STANDARD_AND_EXTENDED)
    return Hearing(LineMode(None, extended=both, error_frames=can(Feature.ERROR_FRAMES)))


def controllers_own(mode: LineMode) -> LineMode:
    """The part of a mode for the controller: the acceptance registers of a kin apply to that kin alone."""
    own = _acceptance_registers(mode)
    if not mode.kin or not own:
        return mode
    return replace(mode, registers=tuple(pair for pair in mode.registers if pair[0] not in own))


def _acceptance_registers(mode: LineMode) -> Mapping[str, int]:
    return {name: value for name, value in mode.registers if name in _CODES or name in _MASKS}
