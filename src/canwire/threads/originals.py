"""The clocks, locks and waits of the standard library, before any of them was replaced."""

from __future__ import annotations

import queue
import select
import selectors
import threading
import time

allocate_lock = threading.Lock
new_reentrant_lock = threading.RLock
sleep = time.sleep
monotonic = time.monotonic
monotonic_ns = time.monotonic_ns
perf_counter = time.perf_counter
perf_counter_ns = time.perf_counter_ns
time_s = time.time
time_ns = time.time_ns
select_select = select.select
select_poll = getattr(select, "poll", None)  # Windows has none
simple_queue = queue.SimpleQueue
start = threading.Thread.start
join = threading.Thread.join
is_alive = threading.Thread.is_alive
select_of = {
    kind: kind.__dict__["select"]
    for kind in vars(selectors).values()
    if isinstance(kind, type) and issubclass(kind, selectors.BaseSelector) and "select" in kind.__dict__
}
"""The method `select` of each selector class that defines one."""
