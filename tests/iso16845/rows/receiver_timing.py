"""Rows of chapters 7.7 receiver: bit timing, classic frames."""

from __future__ import annotations

from tests.iso16845.rows.terms import ALL, EACH_E, Purpose, R

ROWS: tuple[Purpose, ...] = (
    Purpose(
        "7.7.1",
        R,
        "Position of the nominal sample point of a receiver.",
        ALL,
        "1 a configuration, classic frames",
        "LT sends frame S.",
        "First dominant stuff bit shortened by PS2, the second by PS2 + 1 tq (the bits behind move up).",
        "The first is sampled dominant; the second recessive: active flag in the bit behind it (the "
        "first shortening resynchronises by min(PS2, SJW)).",
    ),
    Purpose(
        "7.7.2",
        R,
        "Hard synchronisation to an early SOF in the third intermission bit.",
        ALL,
        "NTQ: e = 1..NTQ",
        "LT sends a frame disturbed by a stuff error; error frame, two intermission bits.",
        "Intermission bit 3 lasts only e tq, then SOF followed by 5 dominant bits (ID 000).",
        "Active flag 6 bit times behind the SOF edge, at most 1 tq earlier.",
    ),
    Purpose(
        "7.7.3",
        R,
        "Late edge, e <= SJW: the whole error is corrected.",
        ALL,
        f"SJW: e = 1..SJW; {EACH_E}",
        "LT sends frame S.",
        "Dominant stuff bit delayed by e tq and shortened by PS2 + 1 tq at its end.",
        "Sampled recessive: active flag 1 bit time behind the delayed edge.",
    ),
    Purpose(
        "7.7.4",
        R,
        "Late edge, e > SJW: only SJW is corrected.",
        ALL,
        f"e = SJW + 1 .. NTQ - PS2 - 1; {EACH_E}",
        "LT sends frame S.",
        "Dominant stuff bit delayed by e tq, shortened by PS2 + 1 + e - SJW tq at its end.",
        "Active flag 1 bit time - (e - SJW) tq behind the delayed edge.",
    ),
    Purpose(
        "7.7.5",
        R,
        "Early edge, |e| <= SJW: the whole error is corrected.",
        ALL,
        f"SJW: |e| = 1..SJW; {EACH_E}",
        "LT sends frame S.",
        "Recessive bit before the stuff bit shortened by |e| tq, then 1 tq dominant, then recessive.",
        "Stuff error: active flag 1 bit time behind the dominant edge.",
    ),
    Purpose(
        "7.7.6",
        R,
        "Early edge, |e| > SJW: only SJW is corrected.",
        ALL,
        f"|e| = SJW + 1 .. PS2; {EACH_E}",
        "LT sends frame S.",
        "As 7.7.5.",
        "Active flag 1 bit time + (|e| - SJW) tq behind the dominant edge.",
    ),
    Purpose(
        "7.7.7",
        R,
        "One synchronisation a bit, both edges before the sample point; one on a pulse of minimum length "
        "counts.",
        ALL,
        "1",
        "LT sends frame S.",
        "Third tq of the first dominant stuff bit forced recessive (edges at tq 1 and tq 4); next 6 bits "
        "recessive (second stuff bit inverted).",
        "Active flag exactly 7 bit times behind the first edge: the second edge does not synchronise, "
        "though the first had no phase error.",
    ),
    Purpose(
        "7.7.8",
        R,
        "The same when the first edge comes early.",
        ALL,
        "1",
        "LT sends frame S.",
        "Bit before the stuff bit shortened by 1 tq; third tq of the stuff bit recessive; next 6 bits "
        "recessive.",
        "Active flag exactly 7 bit times behind the first edge.",
    ),
    Purpose(
        "7.7.9.1",
        R,
        "A dominant pulse on the idle bus that is over before the sample point is no SOF.",
        ALL,
        "1",
        "Bus idle.",
        "Dominant for Prop + PS1 - 1 tq, then 8 recessive bits.",
        "IUT stays idle: no flag, no counter.",
    ),
    Purpose(
        "7.7.9.2",
        R,
        "After the hard synchronisation of the first edge in idle no further edge of that bit synchronises.",
        ALL,
        "1",
        "Bus idle.",
        "Dominant (Prop + PS1 - 2)/2 tq; recessive 2 tq; dominant (Prop + PS1 - 2)/2 tq - 1 minimum tq; "
        "recessive 1 tq + 2 minimum tq; "
        "dominant Prop + PS1 - 2 tq; 8 recessive bits. The sample point counted from the first edge "
        "falls between pulses.",
        "IUT stays idle, no error frame.",
        "That the sample point meets a recessive gap, by which reckoning of the segments, must be "
        "checked for the chosen timing (the last gap lies about there).",
    ),
    Purpose(
        "7.7.10",
        R,
        "No synchronisation on an edge to the level that was sampled last.",
        ALL,
        "1",
        "LT sends a frame with ID 11111000000 (binary).",
        "1 tq recessive at tq NTQ - PS2 + 1 of the first dominant stuff bit (behind its sample point); 5 "
        "more dominant bits (second stuff bit inverted).",
        "Active flag exactly 6 bit times behind the edge at the start of the stuff bit.",
    ),
    Purpose(
        "7.7.11",
        R,
        "Early edge at the ACK slot is corrected.",
        ALL,
        f"SJW: |e| = 1..SJW; {EACH_E}",
        "LT sends a valid classic frame.",
        "Last |e| tq of the CRC delimiter dominant; ACK slot dominant but its last PS2 + |e| tq recessive.",
        "ACK sampled dominant; frame valid, no flag.",
        "For the IUT the disturbing level comes together with its own ACK: force the level it sees.",
    ),
)
