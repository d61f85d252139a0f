"""Signals with a value, as the kernel's timers send them (sigevent(7)): to a process, or to one of its threads."""

from __future__ import annotations

import ctypes
import os
import platform

_PIDFD_SEND_SIGNAL = 424  # the same number on every architecture (asm-generic/unistd.h)
_RT_TGSIGQUEUEINFO = 297 if platform.machine() == "x86_64" else 240
_SI_TIMER = -2
_libc = ctypes.CDLL(None, use_errno=True)


class _Information(ctypes.Structure):
    """siginfo_t of a timer, 128 bytes (asm-generic/siginfo.h)."""

    _fields_ = (
        ("number", ctypes.c_int),
        ("error", ctypes.c_int),
        ("code", ctypes.c_int),
        ("gap", ctypes.c_int),
        ("timer", ctypes.c_int),
        ("overrun", ctypes.c_int),
        ("value", ctypes.c_int64),
        ("rest", ctypes.c_char * 96),
    )


def send_timer_signal(process: int, number: int, value: int, timer: int) -> None:
    """Send a signal to a process; `process` is a pidfd. Raises OSError: ProcessLookupError if it has ended."""
    information = _Information(number=number, code=_SI_TIMER, timer=timer, value=value)
    _check(_libc.syscall(_PIDFD_SEND_SIGNAL, process, number, ctypes.byref(information), 0))


def send_timer_signal_to_thread(process: int, thread: int, number: int, value: int, timer: int) -> None:
    """The same for one thread of a process, by their numbers."""
    information = _Information(number=number, code=_SI_TIMER, timer=timer, value=value)
    _check(_libc.syscall(_RT_TGSIGQUEUEINFO, process, thread, number, ctypes.byref(information)))


def _check(result: int) -> None:
    if result < 0:
        error = ctypes.get_errno()
        raise OSError(error, os.strerror(error))
