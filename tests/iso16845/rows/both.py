"""Rows of chapters 9.6 both ways."""

from __future__ import annotations

from tests.iso16845.rows.terms import ALL, Purpose, R, T

ROWS: tuple[Purpose, ...] = (
    Purpose(
        "9.6.1",
        T,
        "REC and TEC count independently: a high REC, then errors as transmitter.",
        ALL,
        "1",
        "REC 127 (127 disturbed receptions, or preset), TEC 0. IUT sends frame E.",
        "Data bit 7 forced dominant in 16 attempts (TEC 128), then in one more.",
        "Attempts 1..16: active flags, repeated right behind the intermission; then suspend; attempt 17 "
        "(ESI 1): passive flag.",
        "The plan's last error is in a frame of the LT, the public library's in the IUT's repetition; "
        "the 16 attempts leave REC alone.",
    ),
    Purpose(
        "9.6.2",
        R,
        "REC and TEC count independently: a high TEC, then errors as receiver.",
        ALL,
        "1",
        "TEC 127, REC 0. LT sends frame E.",
        "Data bit 7 forced dominant in 128 frames (REC 128, + 1 each), then in one more.",
        "128 active flags, REC + 1 each; the next flag is passive.",
    ),
)
