"""`python -m canwire` is the `canwire` command."""

from __future__ import annotations

import sys

if __name__ == "__main__":
    try:
        from canwire.commands import main

        status = main()
    except KeyboardInterrupt:  # while it was still being loaded
        status = 130
    sys.exit(status)
