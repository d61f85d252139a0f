"""`python -m canwire` is the `canwire` command."""

from __future__ import annotations

import sys

from canwire.commands import main

if __name__ == "__main__":
    sys.exit(main())
