"""`canwire` and `python -m canwire`: the command, which Ctrl-C ends at any moment without a traceback."""

from __future__ import annotations

import signal
import sys


def main() -> int:
    """Run the command line of this process; returns the exit status.

    During imports and after the command, the system handles Ctrl-C: the process holds nothing that it must release,
    and an exception in the middle of an import could block the process.
    """
    ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # ignored: to be left alone
    if ours:
        _leave_to_system()
    from canwire.commands import main as run

    try:
        if ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        return run()
    except KeyboardInterrupt:  # before or after a verb's own work, or a second one while it ended
        return 128 + signal.SIGINT
    finally:
        if ours:
            _leave_to_system()


def _leave_to_system() -> None:
    """Have the system handle Ctrl-C from now on, also if it comes at this moment.

    Python would drop a signal that comes before the change and is handled after it ("ignored due to race condition").
    """
    if sys.platform == "win32":
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    try:
        signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT,))
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


if __name__ == "__main__":
    sys.exit(main())
