"""The only package that depends on the operating system: events, shared memory, and waiting for many descriptors.

`linux.py` uses the fastest means of Linux. `portable/` needs only files, TCP sockets on the loopback address, and
select or kqueue; it runs on Windows, macOS and all other systems, and on Linux if CANWIRE_PLATFORM=portable is set.
Both define the same names with the same behaviour (tests/platform/ compares them).
"""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Any

from canwire.errors import BadValue
from canwire.platform.limits import descriptor_limit as descriptor_limit
from canwire.platform.limits import raise_descriptor_limit as raise_descriptor_limit
from canwire.platform.waiting import signals_end_waits as signals_end_waits
from canwire.platform.waiting import wait_readable as wait_readable

Descriptor = Any
"""Memory or an event on its way to a client: descriptors on Linux, elsewhere objects that represent them."""


def _portable() -> bool:
    asked = os.environ.get("CANWIRE_PLATFORM", "")
    if asked not in ("", "portable"):
        raise BadValue(
            f"CANWIRE_PLATFORM={asked}: portable, or leave it unset for the fastest means of this system"
        )
    return asked == "portable" or sys.platform != "linux"


PORTABLE = _portable()

if TYPE_CHECKING or not PORTABLE:
    from canwire.platform.linux import AnyOf as AnyOf
    from canwire.platform.linux import EventDescriptor as EventDescriptor
    from canwire.platform.linux import Poller as Poller
    from canwire.platform.linux import close_descriptors as close_descriptors
    from canwire.platform.linux import create_memory as create_memory
    from canwire.platform.linux import duplicate as duplicate
    from canwire.platform.linux import map_memory as map_memory
    from canwire.platform.linux import shared_event as shared_event
    from canwire.platform.linux import sharpen_sleep as sharpen_sleep
else:
    from canwire.platform.portable.events import AnyOf as AnyOf
    from canwire.platform.portable.events import EventDescriptor as EventDescriptor
    from canwire.platform.portable.events import shared_event as shared_event
    from canwire.platform.portable.memory import close_descriptors as close_descriptors
    from canwire.platform.portable.memory import create_memory as create_memory
    from canwire.platform.portable.memory import duplicate as duplicate
    from canwire.platform.portable.memory import map_memory as map_memory
    from canwire.platform.portable.polling import Poller as Poller
    from canwire.platform.portable.polling import sharpen_sleep as sharpen_sleep
