"""One CAN connector as its clients see it: initialised, started and stopped, with the filters of its channels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from canwire.boards.board import BoardLine
from canwire.boards.can.abilities import LOW_SPEED_LIMIT, check_mode, check_search, filter_of
from canwire.boards.can.bounds import bounds
from canwire.boards.can.channel import Channel
from canwire.boards.can.crystal import Crystal
from canwire.boards.can.detection import Detection
from canwire.boards.can.hearing import Hearing, controllers_own, hearing_of, unasked
from canwire.boards.can.message_filter import FormatFilter, MessageFilter
from canwire.boards.can.modes import LineMode
from canwire.boards.catalogue import is_shorted, load_of
from canwire.drivers.driver import LineSettings
from canwire.errors import CanwireError, NothingHeard, NotInitialised, WrongState
from canwire.timeline import Timer
from canwire.values.controller_options import USUAL, ControllerOptions
from canwire.values.event import BusEvent, ErrorState, EventKind, InfoCode
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.limits import BTR_OF_BIT_RATE

_COUNTER = 1 << 32
_LOOK_AGAIN_BITS = 4  # the interval between checks when the line waits for the end of a frame on the wire

Done = Callable[[int | CanwireError], None]


class CanLine:
    """States: undefined, `initialise` -> stopped, `start` -> running, `stop` -> stopped, `reset` -> undefined.

    Source: VCI V4 manual 5.2.3 and 5.2.4; rulings 4. No I/O; times are the timeline's.
    """

    def __init__(self, slot: BoardLine) -> None:
        self.info = slot.info
        self.line = slot.line
        self.bus = slot.bus
        self.crystal = Crystal()
        self._options = slot.options
        self.mode: LineMode | None = None
        self._hearings: dict[str, Hearing] = {}  # by kin
        self._after_reset: dict[str, MessageFilter] = {}  # by kin, to be read until it sets the line up again
        self._narrow = False  # the controller holds up what its only kin does not want
        self._own_registers = False  # its acceptance registers are those of its only kin
        self._paused = False  # by `stop`, and not initialised since
        self.origin_ns: int | None = None
        self._overruns = 0
        self._overrun_timer: Timer | None = None
        self._detection: Detection | None = None
        self._stopping: list[Done] = []
        self._bit_ps = 0
        self.line.coupling_fault = lambda: self.coupling_fault

    @property
    def running(self) -> bool:
        return self.line.driver.running

    @property
    def chip_timing(self) -> BitTiming | None:
        """The timing in the chip's registers while the line runs, if a program has written another timing into them."""
        made = self.line.controller.timing
        if made is None or self.mode is None or self.mode.timing is None or not self.running:
            return None
        return None if _in_time(made.nominal) == _in_time(self.mode.timing) else made.nominal

    @property
    def coupling_fault(self) -> bool:
        """Whether the fault-tolerant transceiver reports a fault of its wires."""
        return self.mode is not None and self.mode.low_speed and is_shorted(self.bus)

    def coupling_changed(self) -> None:
        """Report that the wires of its bus were shorted or repaired, if its transceiver can detect that."""
        if self.running and self.mode is not None and self.mode.low_speed:
            self.line.tell(self.line.happening(EventKind.STATE, self.line.timeline.now_ns))

    def load(self) -> float:
        """Load of the line's bus in the last second, 0..100 %."""
        return load_of(self.bus, self.line.timeline.now_ns)

    def initialise(self, mode: LineMode, done: Done) -> None:
        """Reset the line and set it up; `done(0)` is called immediately, or when the bit rate has been found.

        Raises an error for an impossible mode; then nothing has changed.
        """
        check_mode(self.line.name, self.info, mode)
        if mode.timing is not None:
            self.line.driver.check(self._settings(mode, mode.timing))
            hearing_of(mode)
            self._begin_anew()
            self._set_up(mode, mode.timing)
            done(0)
            return
        limit = LOW_SPEED_LIMIT if mode.low_speed else max(BTR_OF_BIT_RATE)
        rates = sorted((rate for rate in BTR_OF_BIT_RATE if rate <= limit), reverse=True)
        candidates = [(BitTiming.from_btr(*BTR_OF_BIT_RATE[rate]), None) for rate in rates]
        check_search(self.line.name, self.info, candidates, mode.timeout_ms, mode.iso_fd, mode.low_speed)
        self.line.driver.check(self._settings(mode, candidates[0][0]))
        self._begin_anew()

        def found(result: int | CanwireError) -> None:
            if isinstance(result, int):
                timing, result = candidates[result][0], 0
                self._set_up(mode, timing)
            done(result)

        self.detect(candidates, mode.timeout_ms, mode.iso_fd, found)

    def start(self) -> None:
        """Start to take part in the bus; does nothing if the line runs already. Raises NotInitialised."""
        if self.mode is None:
            raise NotInitialised(f"{self.line.name}: initialise the line before it is started")
        if self.running:
            return
        now_ns = self.line.timeline.now_ns
        if self.origin_ns is None:
            self.begin_stamps(now_ns)
        self.line.tell(self._info(InfoCode.STARTED, now_ns))
        if self._paused:
            self._paused = False
            self._tell_changed(InfoCode.STARTED)
        self._accept()
        self.line.driver.start(now_ns)

    def _accept(self) -> None:
        """Set the hardware filter to frames that a program wants, if all programs are of one kin; else accept all."""
        kin = self.line.kin
        chosen = self._hearings[kin].filter if kin in self._hearings else None
        self._narrow = chosen is not None and all(channel.kin == kin for channel in self.line.channels())
        if self._narrow and chosen is not None:
            self.line.driver.accept(bounds(chosen.of(False)), bounds(chosen.of(True)))
        else:
            self.line.driver.accept((0, 0), (0, 0))

    def welcome(self, channel: Channel) -> None:
        """Prepare the line for another channel: the controller no longer filters out frames that the channel may
        want.
        """
        if not channel.frames or channel.kin == self.line.kin:
            return
        if self._narrow:
            self._narrow = False
            self.line.driver.accept((0, 0), (0, 0))
        if self._own_registers:
            self._open_registers()

    def _open_registers(self) -> None:
        """Let the controller accept all frames; a running one leaves the bus for that, so wait for the end of a
        frame.
        """
        mode = self.mode
        if mode is None or mode.timing is None or not self._own_registers:
            return
        if self.running and not self.line.driver.idle():
            at_ns = self.line.timeline.now_ns + max(1, self._bit_ps // 1000)
            self.line.timeline.at(at_ns, self._open_registers)
            return
        self._own_registers = False
        self.line.driver.configure(self._settings(mode, mode.timing))

    def when_quiet(self, call: Callable[[], None]) -> None:
        """Call `call` once this line has no frame on the wire, perhaps immediately; it begins no frame until then."""
        if self.running and self.mode is not None and self.line.driver.on_wire():
            self.line.holding = True
            later_ns = _LOOK_AGAIN_BITS * self._bit_ps // 1000
            self.line.timeline.at(self.line.timeline.now_ns + later_ns, partial(self.when_quiet, call))
            return
        self.line.holding = bool(self._stopping)
        call()
        self.line.kick()

    def annotate(self, note: bytes, kin: str = "") -> None:
        """Replace this kin's note and report a change; the controller does not change. Raises NotInitialised."""
        if self.mode is None:
            raise NotInitialised(f"{self.line.name}: initialise the line before it is given a note")
        own = self._hearings.get(kin) or unasked(self.info)
        self._hear(kin, replace(own, mode=replace(own.mode, note=note)))
        self._tell_changed()

    def abort_pending(self) -> None:
        """Discard the queued frames of all channels, except a frame on the wire."""
        for channel in self.line.channels():
            self.line.cancel(channel)

    def stop(self, done: Done) -> None:
        """Leave the bus; `done(0)` is called when the frame that the line is sending, if any, has ended."""
        if not self.running:
            done(0)
            return

        def stopped(result: int | CanwireError) -> None:
            if self.mode is not None and not self._paused:
                self._paused = True
                self._tell_changed(InfoCode.STOPPED)
            done(result)

        self._leave(stopped)

    def _leave(self, done: Done) -> None:
        self._stopping.append(done)
        self.line.holding = True
        self._stop_when_quiet()

    def _begin_anew(self) -> None:
        """Reset the line; if it was set up, the other programs on it receive an event."""
        if self.mode is not None:
            self._tell_leaving(InfoCode.RESET)
        self._clear()

    def recover(self, done: Done, *, abort_pending: bool = False) -> None:
        """After bus-off, leave the bus and join it again with cleared counters; in any other state do nothing."""
        if self.line.driver.counters().state != ErrorState.BUS_OFF or not self.running:
            done(0)
            return

        def stopped(_: int | CanwireError) -> None:
            if abort_pending:
                self.abort_pending()
            self.start()
            done(0)

        self._leave(stopped)

    def reset(self, kin: str = "") -> None:
        """Leave the bus, even in the middle of a bit, and discard the settings; channels' queues keep their content.

        The filters of this kin return to the modes of `initialise`, which can be read (source: VCI V4 manual 5.2.4;
        rulings 4); the settings of programs of other kins stay.
        """
        if (own := self._hearings.get(kin)) is not None and own.filter is not None:
            self._after_reset[kin] = filter_of(own.mode)
        was_set_up = self.mode is not None
        self._tell_leaving(InfoCode.RESET)
        self._clear()
        self._forget(kin)
        if was_set_up:
            self._tell_changed(InfoCode.RESET)

    def abandon(self) -> None:
        """Return to the state after plugging in, when no program has anything open on the line any more."""
        self.reset()
        for kin in list(self._hearings):
            self._forget(kin)
        self._after_reset.clear()

    def release(self, present: set[str]) -> None:
        """Remove the settings of all kins without open programs, that is, not in `present`, unless they are kept."""
        for kin, own in list(self._hearings.items()):
            if kin and kin not in present and not own.mode.keeps:
                self._forget(kin)
                self._after_reset.pop(kin, None)

    def seen_by(self, kin: str) -> LineMode | None:
        """The mode of the line, with formats, error reports, filters and note as programs of this kin set them."""
        if self.mode is None:
            return None
        return (self._hearings.get(kin) or unasked(self.info)).seen(self.mode)

    def in_effect(self, kin: str) -> LineMode | None:
        """The same as `seen_by`, with the controller's options that are in effect, those of canwire.toml included."""
        mode = self.seen_by(kin)
        if mode is None or (options := self._options_of(mode)) == (mode.options or USUAL):
            return mode
        return replace(mode, options=options)

    def detect(
        self,
        candidates: Sequence[tuple[BitTiming, BitTiming | None]],
        timeout_ms: int,
        iso_fd: bool,
        done: Done,
        *,
        low_speed: bool = False,
    ) -> None:
        """Find the bit rate of the bus, only listening: `done` gets its index in the candidates, or NothingHeard.

        With `low_speed`, candidates that this coupling does not support are skipped.
        Raises WrongState while the line runs or searches already, and errors for what is impossible.
        """
        if self.running or self._detection is not None:
            raise WrongState(f"{self.line.name}: stop the line before it looks for a bit rate")
        check_search(self.line.name, self.info, candidates, timeout_ms, iso_fd, low_speed)
        possible = [
            at
            for at, (nominal, _) in enumerate(candidates)
            if not low_speed or nominal.exact_bit_rate <= LOW_SPEED_LIMIT
        ]
        if candidates and not possible:
            done(NothingHeard(f"{self.line.name}: no bit rate up to {LOW_SPEED_LIMIT} to try at low speed"))
            return

        def finished(result: int | CanwireError) -> None:
            self._detection = None
            done(possible[result] if isinstance(result, int) else result)

        self._detection = Detection(
            self.line.name,
            self.bus,
            self.line.timeline,
            [candidates[at] for at in possible],
            timeout_ms,
            iso_fd,
            finished,
        )
        self._detection.begin()

    def format_filter(self, extended: bool, kin: str = "") -> FormatFilter:
        """This kin's filter of one frame format; raises NotInitialised before `initialise`."""
        if self.mode is None:
            raise NotInitialised(f"{self.line.name}: a line has filters once it is initialised")
        own = self._hearings.get(kin) or unasked(self.info)
        if own.filter is None:  # programs of another kin have set the line up
            own = replace(own, filter=filter_of(own.mode))
            self._hear(kin, own)
        assert own.filter is not None
        return own.filter.of(extended)

    def filter_mode(self, extended: bool, kin: str = "") -> int:
        """The filter mode of one frame format; after a reset that of `initialise`. Raises NotInitialised before it."""
        if self.mode is None and kin in self._after_reset:
            return self._after_reset[kin].of(extended).mode
        return self.format_filter(extended, kin).mode

    def begin_stamps(self, now_ns: int) -> None:
        """Start the time-stamp counter at 0, at the first start after a reset."""
        self.origin_ns = now_ns
        for channel in self.line.channels():
            channel.origin_ns = now_ns
        self._overruns = 0
        self._await_overrun()

    def close(self, why: CanwireError) -> None:
        """End every pending call with `why`: the board was unplugged."""
        if self._detection is not None:
            self._detection.cancel(why)
        self._clear()

    def _set_up(self, mode: LineMode, timing: BitTiming) -> None:
        own = controllers_own(mode)
        strangers = any(channel.frames and channel.kin != mode.kin for channel in self.line.channels())
        self._own_registers = own is not mode and not strangers
        self.line.driver.configure(self._settings(mode, timing))
        self.crystal.configured(self.line.controller)
        self._bit_ps = timing.bit_time_ps
        line = self.line
        line.long_data, line.fast_data = mode.long_data, mode.data_timing is not None
        line.kin = mode.kin
        self._hear(mode.kin, hearing_of(mode))
        self.mode = replace(mode, timing=timing)
        self._tell_changed()

    def _hear(self, kin: str, hearing: Hearing) -> None:
        self._hearings[kin] = hearing
        self._after_reset.pop(kin, None)
        self.line.hear(kin, hearing)

    def _forget(self, kin: str) -> None:
        if self._hearings.pop(kin, None) is not None:
            self.line.hear(kin, unasked(self.info))

    def _tell_changed(self, code: int = 0) -> None:
        """Report that the line was set up again, or was stopped, started again or reset, by the InfoCode."""
        self.line.tell(self.line.happening(EventKind.CHANGED, self.line.timeline.now_ns, code))

    def _clear(self) -> None:
        """Leave the bus at this moment, empty the mailboxes and discard the settings."""
        line, now_ns = self.line, self.line.timeline.now_ns
        if self._detection is not None:
            self._detection.cancel()
        if self.running:
            line.driver.stop(now_ns)
        for box in line.driver.boxes:
            line.driver.abort(box, now_ns)
        line.driver.forget()
        self.mode = self.origin_ns = None
        self._paused = self._narrow = self._own_registers = False
        if self._overrun_timer is not None:
            self._overrun_timer.cancel()
        self._stopped()

    def _stop_when_quiet(self) -> None:
        if self.running and self.mode is not None and self.line.driver.on_wire():
            later_ns = _LOOK_AGAIN_BITS * self._bit_ps // 1000
            self.line.timeline.at(self.line.timeline.now_ns + later_ns, self._stop_when_quiet)
        elif self._stopping:
            self._tell_leaving(InfoCode.STOPPED)
            self.line.driver.stop(self.line.timeline.now_ns)
            self._stopped()

    def _stopped(self) -> None:
        self.line.holding = False
        waiting, self._stopping = self._stopping, []
        for done in waiting:
            done(0)

    def _await_overrun(self) -> None:
        tick_ns = self.info.capabilities.stamps.tick_ns
        if tick_ns and self.origin_ns is not None:
            at_ns = self.origin_ns + (self._overruns + 1) * _COUNTER * tick_ns
            self._overrun_timer = self.line.timeline.at(at_ns, self._tell_overrun, background=True)

    def _tell_overrun(self) -> None:
        self._overruns += 1
        self.line.tell(self.line.happening(EventKind.TIME_OVERRUN, self.line.timeline.now_ns, code=1))
        self._await_overrun()

    def _tell_leaving(self, code: InfoCode) -> None:
        """Report why the line stops, with its state after that: real boards do so before they report the state
        itself.
        """
        told = self._info(code, 0)
        pending = told.pending and code == InfoCode.STOPPED  # a reset empties the mailboxes
        self.line.tell(replace(told, state=ErrorState.STOPPED, pending=pending), False)

    def _info(self, code: InfoCode, at_ns: int) -> BusEvent:
        return self.line.happening(EventKind.INFO, at_ns, code)

    def _settings(self, mode: LineMode, timing: BitTiming) -> LineSettings:
        fd_timing = mode.data_timing or (timing if mode.long_data else None)
        return LineSettings(
            timing,
            fd_timing,
            mode.iso_fd,
            mode.listen_only,
            registers=(mode if self._own_registers else controllers_own(mode)).registers,
            loop_back=mode.loop_back,
            options=self._options_of(mode),
        )

    def _options_of(self, mode: LineMode) -> ControllerOptions:
        """The options that a program set, combined with those that the board determines."""
        return self._options if mode.options is None else mode.options.on_board(self._options)


def _in_time(timing: BitTiming) -> tuple[int, int]:
    """The parts of a timing that matter with any clock; a chip's driver may have made SJW shorter."""
    return timing.bit_time_ps, timing.sample_time_ps
