"""Fault confinement: the two error counters, and the error state that follows from them.

The rules by number are those of reference/can-protocol.md section 7 (ISO 11898-1:2015 12.1.4, Bosch CAN 2.0
chapter 8). Shared by every CAN chip.
"""

from __future__ import annotations

WARNING_LIMIT = 96
PASSIVE_LIMIT = 128
BUS_OFF_LIMIT = 256
ACTIVE, WARNING, PASSIVE, BUS_OFF = range(4)  # ErrorState's first four
_ACTIVE, _WARNING, _PASSIVE, _BUS_OFF = ACTIVE, WARNING, PASSIVE, BUS_OFF
_WARNING_LIMIT, _PASSIVE_LIMIT, _BUS_OFF_LIMIT = WARNING_LIMIT, PASSIVE_LIMIT, BUS_OFF_LIMIT

# by rule: (added to TEC, added to REC); rules 7 and 8, which count down, have separate methods
_TEC_STEP = (0, 0, 0, 8, 8, 0, 8, 0, 0)
_REC_STEP = (0, 1, 8, 0, 0, 8, 0, 8, 0)
_RULES = len(_TEC_STEP)
_RECEIVED_RULE = 8
_REC_AFTER_PASSIVE = 127  # "a value between 119 and 127"


class Confinement:
    """TEC, REC and the error state that follows from them.

    `tec` is held at 256 once the controller is bus-off; `rec` is held at 255, as registers do. `warning_limit` is
    96 unless a chip lets it be set.
    """

    def __init__(self) -> None:
        self.tec = 0
        self.rec = 0
        self.state = ACTIVE
        self.warning_limit = WARNING_LIMIT

    def apply(self, rule: int) -> bool:
        """Apply one counter rule of bus/can/node.py; True if the state changed."""
        if self.state == _BUS_OFF:
            return False
        if rule == _RECEIVED_RULE:
            return self.received()
        if rule < 0 or rule >= _RULES:
            raise ValueError(f"rule {rule}: there are 0 to {_RULES - 1}")
        self.tec = min(self.tec + _TEC_STEP[rule], _BUS_OFF_LIMIT)
        self.rec = min(self.rec + _REC_STEP[rule], 255)
        return self._settle()

    def transmitted(self) -> bool:
        """Count a transmitted frame (rule 7); True if the state changed."""
        if self.tec == 0 or self.state == _BUS_OFF:
            return False
        self.tec -= 1
        return self._settle()

    def received(self) -> bool:
        """Count a frame received without error (rule 8); True if the state changed."""
        if self.rec == 0 or self.state == _BUS_OFF:
            return False
        self.rec = self.rec - 1 if self.rec < _PASSIVE_LIMIT else _REC_AFTER_PASSIVE
        return self._settle()

    def reset(self) -> None:
        """Set both counters to 0, error active: after reset, and after recovery from bus-off (rule 12)."""
        self.tec = self.rec = 0
        self.state = _ACTIVE

    def _settle(self) -> bool:
        before = self.state
        worst = self.tec if self.tec > self.rec else self.rec
        if self.tec >= _BUS_OFF_LIMIT:
            self.state = _BUS_OFF
        elif worst >= _PASSIVE_LIMIT:
            self.state = _PASSIVE
        elif worst >= self.warning_limit:
            self.state = _WARNING
        else:
            self.state = _ACTIVE
        return self.state != before
