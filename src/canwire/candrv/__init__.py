"""CANDRV: the interface of F&S's CAN driver for Windows CE, on canwire's boards.

Source: CANDRV manual V2.06 (seed 000).
"""

from __future__ import annotations
