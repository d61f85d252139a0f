"""A pytest plugin for .ci/sanitizers: rings get their memory from malloc, where the sanitizer sees what is beyond.

Anonymous maps, which they have otherwise, end with a page, and nobody notices a write just behind them.
"""

from __future__ import annotations

from canwire import ring

ring.own_memory = lambda size: memoryview(bytearray(size))  # type: ignore[assignment]
