"""Arrays of messages need numpy, which is loaded at the first use."""

from __future__ import annotations

from typing import Any

from canwire import ExtraMissing


def load_numpy() -> Any:
    """numpy; raises ExtraMissing without it."""
    try:
        import numpy
    except ModuleNotFoundError:
        raise ExtraMissing("numpy", "arrays") from None
    return numpy
