"""Names of ASAM's bus logging."""

from __future__ import annotations

from typing import Any

from canwire.errors import ExtraMissing
from canwire.values.record import ERROR_STATE_INDICATOR, EXTENDED, EXTENDED_DATA_LENGTH, FAST_DATA_RATE

FLAGS = {"IDE": EXTENDED, "EDL": EXTENDED_DATA_LENGTH, "BRS": FAST_DATA_RATE, "ESI": ERROR_STATE_INDICATOR}
DATA, REMOTE_FRAME, ERROR, LIN = "CAN_DataFrame", "CAN_RemoteFrame", "CAN_ErrorFrame", "LIN_Frame"


def load_asammdf() -> Any:
    """Return asammdf; raises ExtraMissing, which names the extra."""
    try:
        import asammdf
        import asammdf.blocks.utils
    except ModuleNotFoundError:
        raise ExtraMissing("asammdf", "mf4") from None
    return asammdf
