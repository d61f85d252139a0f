"""The inside of a frame as every node goes through it, sender and receivers alike: one `yield` a bit, top to bottom.

Source: ISO 11898-1:2015 8.4, 10.4 and 11.2; reference/can-protocol.md sections 1 to 4, 6 and 7.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Any, NamedTuple

from tests.bus.can.reference_bits import FD_LENGTH, GRAY_AND_PARITY

DOMINANT, RECESSIVE = 0, 1
NEXT_BIT = (
    -1
)  # yielded: "wake me where my next bit begins"; a level yielded: "I drive this, wake me at my sample"
Bits = Generator[int, int, Any]


class Wrong(Exception):
    """An error was detected; `exempt`: rule 3's exception B."""

    def __init__(self, kind: str, *, exempt: bool = False, in_frame: bool = True) -> None:
        self.kind = kind
        self.exempt = exempt
        self.in_frame = in_frame


class ExceptionState(Exception):
    """The protocol exception: res was recessive."""


class Overload(Exception):
    """An overload condition."""


class Heard(NamedTuple):
    """A frame as it was read."""

    id: int
    extended: bool
    remote: bool
    fd: bool
    bit_rate_switch: bool
    error_state_indicator: bool
    dlc: int
    data: bytes


class FrameMachine:
    """Reads a frame, and sends it where `transmitting`.

    `levels` is what a sender drives from SOF to EOF, `index` the present bit of the frame, `arbitration_bits`
    how many bits its sender's arbitration field has.
    """

    knows_fd = False
    listen_only = False
    transmitting = False
    levels = ""
    arbitration = ""
    arbitration_bits = 0

    # told by the frame to its clock and its node

    def place(self, name: str) -> None:
        """Where this node is: what its clock must know."""
        raise NotImplementedError

    def data_rate(self, on: bool) -> None:
        """From this sample point on."""
        raise NotImplementedError

    def settle(self) -> None:
        """A bit begins."""
        raise NotImplementedError

    def lose(self, bit: int) -> None:
        """Arbitration is lost."""
        raise NotImplementedError

    def reception_is_well(self) -> None:
        """Rule 8's moment: the ACK bit has been sent successfully."""
        raise NotImplementedError

    def frame_is_over(self, heard: Heard) -> None:
        """The last bit of EOF has been sampled."""
        raise NotImplementedError

    # bits

    def begin(self) -> None:
        """SOF has been read, or sent."""
        self.part = "frame"
        self.place("frame")
        self.index = 1
        self.taken = 0  # bits without SOF and stuff bits
        self.run = 1
        self.last = DOMINANT
        self.stuff_bits = 0
        self.fast = False
        self.plain = [DOMINANT]
        self.wired = [DOMINANT]

    def bit(self, drive: int) -> Bits:
        """One bit: what is sampled while `drive` is driven."""
        yield NEXT_BIT
        self.settle()
        return (yield drive)

    def frame_bit(self, *, stuff: bool = False, drive: int = RECESSIVE, delimiter: bool = False) -> Bits:
        """One bit of the frame; a sender compares."""
        yield NEXT_BIT
        self.settle()
        self.place(self.part)
        if self.transmitting:
            drive = int(self.levels[self.index]) if self.index < len(self.levels) else RECESSIVE
        level = yield drive
        self.index += 1
        if self.transmitting and level != drive:
            self.compare(level, stuff, delimiter)
        elif level > drive:
            raise Wrong("BIT")  # the ACK that it sends
        return level

    def compare(self, level: int, stuff: bool, delimiter: bool) -> None:
        """A sender has read another level than it drives."""
        if delimiter:
            raise Wrong("FORM")
        if level == DOMINANT and self.taken < self.arbitration_bits:
            if stuff:
                raise Wrong("STUFF", exempt=True)
            self.transmitting = False
            self.lose(self.taken)
        else:
            raise Wrong("FAST_DATA_BIT" if self.fast else "BIT")

    def take(self, count: int) -> Bits:
        """So many bits of the stuffed part, without the stuff bits."""
        value = 0
        for _ in range(count):
            if self.run == 5:
                self.wired.append((yield from self.stuff_bit()))
            level = yield from self.frame_bit()
            self.taken += 1
            self.run = self.run + 1 if level == self.last else 1
            self.last = level
            self.plain.append(level)
            self.wired.append(level)
            value = 2 * value + level
        return value

    def stuff_bit(self) -> Bits:
        level = yield from self.frame_bit(stuff=True)
        if level == self.last:
            raise Wrong("STUFF")
        self.last = level
        self.run = 1
        self.stuff_bits += 1
        return level

    # the frame

    def frame(self) -> Bits:
        """Everything behind SOF."""
        id = yield from self.take(11)
        remote = yield from self.take(1)  # or SRR, or RRS
        extended = yield from self.take(1)
        if extended:
            id = id << 18 | (yield from self.take(18))
            remote = yield from self.take(1)
        fdf = yield from self.take(1)
        if fdf and self.knows_fd:
            yield from self.flexible(id, bool(extended))
        else:
            yield from self.classic(id, bool(extended), bool(remote))

    def classic(self, id: int, extended: bool, remote: bool) -> Bits:
        if extended:
            yield from self.take(1)  # r0, of either level
        dlc = yield from self.take(4)
        data = yield from self.data(0 if remote else min(dlc, 8))
        check = crc(self.plain, 0x4599, 15, 0)
        good = (yield from self.take(15)) == check
        if self.run == 5:
            yield from self.stuff_bit()
        yield from self.tail(good, Heard(id, extended, remote, False, False, False, dlc, data))

    def flexible(self, id: int, extended: bool) -> Bits:
        if not self.transmitting:
            self.part = "res"  # from here to its sample point
            self.place("res")
        if (yield from self.take(1)):
            raise ExceptionState
        self.part = "frame"
        self.place("frame")
        switch = yield from self.take(1)
        if switch:
            self.fast = True
            self.data_rate(True)
        passive = yield from self.take(1)
        dlc = yield from self.take(4)
        data = yield from self.data(FD_LENGTH[dlc])
        good = yield from self.flexible_check(17 if len(data) <= 16 else 21)
        heard = Heard(id, extended, False, True, bool(switch), bool(passive), dlc, data)
        yield from self.tail(good, heard)

    def data(self, length: int) -> Bits:
        data = bytearray()
        for _ in range(length):
            data.append((yield from self.take(8)))
        return bytes(data)

    def flexible_check(self, width: int) -> Bits:
        """Stuff count and CRC, with a fixed stuff bit before each group of four bits: is it right?"""
        covered = self.wired
        expected = GRAY_AND_PARITY[self.stuff_bits % 8]
        read = ""
        for k in range(4 + width):
            if k % 4 == 0:
                fixed = yield from self.frame_bit()
                if fixed == self.last:
                    raise Wrong("FORM")
            self.last = yield from self.frame_bit()
            read += str(self.last)
        counted = [int(level) for level in read[:4]]
        polynomial = 0x1685B if width == 17 else 0x102899
        check = crc(covered + counted, polynomial, width, 1 << (width - 1))
        return read == expected + format(check, f"0{width}b")

    def tail(self, good: bool, heard: Heard) -> Bits:
        """CRC delimiter, ACK slot, ACK delimiter, EOF."""
        if (yield from self.frame_bit(delimiter=True)) == DOMINANT:
            raise Wrong("FORM")
        self.fast = False
        self.data_rate(False)
        yield from self.acknowledge(good, heard.fd)
        for bit in range(1, 8):
            level = yield from self.frame_bit(delimiter=True)
            if level == DOMINANT and bit < 7:
                raise Wrong("FORM")
        self.frame_is_over(heard)
        if level == DOMINANT:
            raise Overload

    def acknowledge(self, good: bool, fd: bool) -> Bits:
        """The ACK slot (in FD frames up to two bits are tolerated) and its delimiter."""
        acknowledges = good and not self.transmitting and not self.listen_only
        level = yield from self.ack_bit(DOMINANT if acknowledges else RECESSIVE)
        if acknowledges:
            self.reception_is_well()
        acknowledged = level == DOMINANT
        if self.transmitting and not acknowledged and not fd:
            raise Wrong("ACK")
        level = yield from self.ack_bit(RECESSIVE) if fd else self.frame_bit(delimiter=True)
        if fd and level == DOMINANT:
            acknowledged = True
            level = yield from self.frame_bit(delimiter=True)
        if self.transmitting and not acknowledged:
            raise Wrong("ACK")
        if not self.transmitting and not good:
            raise Wrong("CRC")
        if level == DOMINANT:
            raise Wrong("FORM")

    def ack_bit(self, drive: int) -> Bits:
        """Here a sender drives recessive and may read either."""
        yield NEXT_BIT
        self.settle()
        self.place("frame")
        level = yield drive
        self.index += 1
        if level > drive:
            raise Wrong("BIT")
        return level


def crc(bits: list[int], polynomial: int, width: int, start: int) -> int:
    """Section 3: next = bit XOR msb; shift left; if next XOR polynomial."""
    register, mask = start, (1 << width) - 1
    for bit in bits:
        following = bit ^ register >> (width - 1)
        register = register << 1 & mask
        if following:
            register ^= polynomial
    return register
