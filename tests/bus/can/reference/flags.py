"""Error and overload frames: flags, what is counted while they last, delimiters.

Source: ISO 11898-1:2015 10.4.4, 10.4.5, 12.1.4; reference/can-protocol.md sections 5 and 7.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tests.bus.can.reference.confinement import Confinement
from tests.bus.can.reference.frames import DOMINANT, RECESSIVE, Bits, FrameMachine, Overload, Wrong


class FlagMachine(FrameMachine):
    """What a node does about an error; `follows` is what comes behind."""

    confinement: Confinement
    attempt: Any = None
    follows = ""

    def passive(self) -> bool:
        """Its error flags are recessive."""
        raise NotImplementedError

    def count(self, rule: Callable[[], None], told: tuple[Any, ...] = ()) -> None:
        """Apply a rule, and tell of the error if it is one."""
        raise NotImplementedError

    def error_frame(self, wrong: Wrong) -> Bits:
        """Rules 1 and 3, then the flag of the state before, then what everybody does behind flags."""
        passive = self.passive()
        self.fast = False
        self.data_rate(False)
        self.place("flag")
        spared = self.transmitting and passive and wrong.kind == "ACK"  # rule 3, exception A
        bit = self.index - 1 if wrong.in_frame else None
        self.count(self.rule_for(wrong.exempt or spared), ("error", wrong.kind, bit, self.transmitting))
        self.attempt = None
        yield from self.passive_flag(spared) if passive else self.active_flag()
        yield from self.delimiter(rule_2=True)

    def rule_for(self, none: bool) -> Callable[[], None]:
        if none:
            return lambda: None
        return self.confinement.transmitter_error if self.transmitting else self.confinement.receiver_error

    def overload_frame(self) -> Bits:
        self.place("flag")
        if self.listen_only:
            yield from self.passive_flag(False)
            yield from self.delimiter(rule_2=False)
        else:
            error = yield from self.active_flag()
            yield from self.delimiter(rule_2=error)

    def active_flag(self) -> Bits:
        """Six dominant bits; a recessive one among them is an error, and an error flag begins anew."""
        for _ in range(6):
            if (yield from self.bit(DOMINANT)) == RECESSIVE:
                passive = self.passive()
                self.count_severe()
                yield from self.passive_flag(False) if passive else self.active_flag()
                return True
        return False

    def passive_flag(self, spared: bool) -> Bits:
        """Complete with six equal bits; a dominant one ends what exception A spared."""
        last, equal = RECESSIVE, 0
        while equal < 6:
            level = yield from self.bit(RECESSIVE)
            equal = equal + 1 if level == last else 1
            last = level
            if level == DOMINANT and spared:
                spared = False
                self.count(self.confinement.transmitter_error)

    def delimiter(self, *, rule_2: bool) -> Bits:
        """Wait for a recessive bit, and seven more."""
        dominant = 0
        while (yield from self.bit(RECESSIVE)) == DOMINANT:
            dominant += 1
            if dominant == 1 and rule_2 and not self.transmitting:
                self.count(self.confinement.severe_receiver_error)
            if dominant % 8 == 0:
                self.count_severe()
        for bit in range(2, 9):
            if (yield from self.bit(RECESSIVE)) == DOMINANT:
                if bit == 8:
                    raise Overload
                raise Wrong("FORM", in_frame=False)
        self.follows = "intermission"

    def count_severe(self) -> None:
        """Rules 4, 5 and 6."""
        confinement = self.confinement
        self.count(confinement.transmitter_error if self.transmitting else confinement.severe_receiver_error)
