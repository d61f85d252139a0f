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
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from canwire.commands import main as run

    try:
        if ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        return run()
    except KeyboardInterrupt:  # before or after a verb's own work, or a second one while it ended
        return 128 + signal.SIGINT
    finally:
        if ours:
            signal.signal(signal.SIGINT, signal.SIG_DFL)


if __name__ == "__main__":
    sys.exit(main())
