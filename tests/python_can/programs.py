"""What the fixtures of python-can's tests hand out: programs and buses."""

from __future__ import annotations

import subprocess
from collections.abc import Callable

from canwire.python_can import CanwireBus

Program = Callable[..., subprocess.Popen[str]]  # starts an unmodified python-can program, given as text
Open = Callable[..., CanwireBus]  # makes a bus on the test's hub
