"""Node_attributes of a LIN description: the data with which a slave answers node configuration.

Source: LIN 2.2A 9.2.2.2; ldfparser 0.26.
"""

from __future__ import annotations

from typing import Any

from canwire.values.lin.configuration import LinNodeAttributes, LinProduct
from canwire.values.lin.transport import TIMEOUT_NS

_NS = 1_000_000_000


def attributes_of(slave: Any) -> LinNodeAttributes | None:
    """Return the attributes of ldfparser's slave; None for LIN 1.3 or without a product, which have
    no configuration."""
    product, protocol = getattr(slave, "product_id", None), str(getattr(slave, "lin_protocol", ""))
    if product is None or protocol.startswith("1."):
        return None
    configured = getattr(slave, "configured_nad", None)
    initial = getattr(slave, "initial_nad", None)
    nad = configured if initial is None else initial
    frames = getattr(slave, "configurable_frames", None) or {}
    return LinNodeAttributes(
        LinProduct(product.supplier_id, product.function_id, product.variant or 0),
        nad=1 if nad is None else nad,
        frames={key: frame.frame_id for key, frame in frames.items() if hasattr(frame, "frame_id")},
        message_ids=protocol == "2.0",
        p2_ns=_nanoseconds(getattr(slave, "p2_min", None), 50_000_000),
        n_as_ns=_nanoseconds(getattr(slave, "n_as_timeout", None), TIMEOUT_NS),
        n_cr_ns=_nanoseconds(getattr(slave, "n_cr_timeout", None), TIMEOUT_NS),
    )


def _nanoseconds(seconds: float | None, usual: int) -> int:
    return usual if seconds is None else round(seconds * _NS)
