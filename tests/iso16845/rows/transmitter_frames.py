"""Rows of chapters 8.1 transmitter: valid frames; 8.2 transmitter: detection of errors."""

from __future__ import annotations

from tests.iso16845.rows.terms import ALL, FD, IDS, IDS_EXT, STUFF_64, STUFF_BASE_FD, Purpose, T

ROWS: tuple[Purpose, ...] = (
    Purpose(
        "8.1.1",
        T,
        "A transmitter sends base-format data frames of any identifier and length.",
        ALL,
        f"classic {IDS} x DLC 0..8 = 45; FD {IDS} x all 16 DLC = 80 (BRS 1, ESI 0)",
        "IUT sends the frame, LT acknowledges.",
        "None.",
        "No error flag; every bit on the wire is that of the frame asked for.",
        "A device with fewer payload bytes pads with CC.",
    ),
    Purpose(
        "8.1.2",
        T,
        "The same in extended format.",
        ALL,
        f"classic {IDS_EXT} x DLC 0..8 = 45; FD {IDS_EXT} x all 16 DLC = 80",
        "IUT sends the frame, LT acknowledges.",
        "None.",
        "No error flag; every bit as asked for.",
    ),
    Purpose(
        "8.1.3",
        T,
        "Arbitration can be lost at every recessive identifier bit of a base-format frame.",
        ALL,
        "11: ID 7EF at its 10 recessive bits, ID 010 at its one",
        "IUT sends ID 7EF (or 010), RTR/RRS 0.",
        "LT sends that bit dominant and goes on with a valid frame of its own.",
        "IUT turns receiver at that sample, acknowledges; repeats its frame behind intermission bit 3; "
        "no error flag.",
        "Public descriptions say no data field, the public library sends one byte.",
    ),
    Purpose(
        "8.1.4",
        T,
        "The same in extended format, with SRR and IDE.",
        ALL,
        "31: ID 1FBFFFFF at its 28 recessive bits, ID 00400000 at its one, SRR and IDE with ID 00400000",
        "IUT sends the frame, RTR/RRS 0.",
        "LT sends that bit dominant and goes on with a valid frame (for SRR an extended frame with SRR "
        "dominant or a base frame; for IDE a base remote frame; FD: base frame with RRS 1).",
        "As 8.1.3.",
        "A base-ID end of zeros with SRR dominant brings a stuff bit in LT's frame.",
    ),
    Purpose(
        "8.1.5",
        T,
        "A frame is valid for its transmitter with the end of the EOF.",
        ALL,
        "1",
        "IUT sends a frame, LT acknowledges.",
        "Intermission bit 1 forced dominant.",
        "Overload frame from bit 2, no error flag; the frame is not sent again (15 recessive bits observed).",
    ),
    Purpose(
        "8.1.6",
        T,
        "A transmitter puts stuff bits right in base format.",
        ALL,
        "classic 6; FD 10",
        "Classic 078/08/01 then 7xE1; 41F/01/00; 47F/01/1F; 758/00/-; 777/01/1F; 7EF/42/- (remote). "
        f"FD: {STUFF_BASE_FD}, with frame 5 CTRL 08F. IUT passive where ESI 1 is asked for (frames 3, 4, "
        "10).",
        "None; LT acknowledges.",
        "No error flag; all stuff bits as they must be.",
        "ID of FD frame 2 is printed 4C7 in one place and 47C in all others.",
    ),
    Purpose(
        "8.1.7",
        T,
        "The same in extended format.",
        ALL,
        "classic 3; FD 10",
        "Classic 07C30F0F/188/8x3C; 07C0F0F0/181/00; 1FB80000/181/A0. FD 01E38787/6AE/F8 then 47x78; "
        "11F3C3C3/6A8/8x3C; 1079C1E1/6BE/48x1E; 083DF0F0/69F/64x0F; "
        "041EF878/68F/64x87; 1F0C3C3C/683/3xC3; 0F861E1E/6A3/3xE1; 07C30F0F/6A1/F0; 1FFC0000/6A0/-; "
        "0003FFFF/6B0/-. Passive for ESI 1 (3, 4, 10).",
        "None; LT acknowledges.",
        "No error flag; all stuff bits as they must be.",
    ),
    Purpose(
        "8.1.8",
        T,
        "With a frame pending, an SOF in intermission bit 3 behind the winner's frame counts as the "
        "IUT's own.",
        ALL,
        "2: ID with 4 leading dominant bits (e.g. 07B); with 5 leading dominant or recessive bits (e.g. 03B)",
        "IUT loses arbitration to LT's frame (same ID - 1).",
        "Intermission bit 3 dominant (LT's SOF).",
        "IUT sends the first identifier bit in the next bit, no SOF of its own, and the whole frame; LT "
        "acknowledges.",
        "The plan says 5 recessive bits for test 2, the public library uses an ID with 5 dominant ones "
        "(stuff bit counting the foreign SOF). Do both.",
    ),
    Purpose(
        "8.2.1",
        T,
        "A transmitter sees a bit error anywhere in a base-format frame.",
        ALL,
        "classic 13: at least one dominant and one recessive bit of each field (arbitration: dominant "
        "ones only; not the ACK slot); FD 21: the same and dominant / recessive, ordinary / fixed stuff "
        "bit of CRC-17 and CRC-21",
        "IUT sends a data frame, LT acknowledges.",
        "One bit inverted for the IUT: SOF, ID (dominant), control, data, CRC, ACK delimiter, EOF.",
        "Active flag from the next bit; the frame is repeated behind the intermission.",
        "Which 13 the plan means is not known in full: choose fixed ones.",
    ),
    Purpose(
        "8.2.2",
        T,
        "The same in extended format.",
        ALL,
        "classic 14: as 8.2.1 with a dominant extension bit, FDF and r0; FD 21",
        "IUT sends an extended data frame, LT acknowledges.",
        "As 8.2.1.",
        "As 8.2.1.",
        "As 8.2.1.",
    ),
    Purpose(
        "8.2.3",
        T,
        "A transmitter sees a disturbed stuff bit in base format.",
        ALL,
        "classic 35 (every stuff bit of 6 frames); FD 39 (every stuff bit up to payload byte 2 of 10 frames)",
        "Frames of 8.1.6; FD: byte 0 as there, all others 55.",
        "One stuff bit inverted for the IUT.",
        "Error flag from the next bit (active; passive where the IUT is passive for ESI 1); the frame is "
        "repeated behind the intermission (passive: + 8 bits suspend).",
        "A recessive stuff bit in the arbitration field is a stuff error without TEC change (8.6.19); "
        "elsewhere a bit error.",
    ),
    Purpose(
        "8.2.4",
        T,
        "The same in extended format.",
        ALL,
        "classic 42 by our calculation (every stuff bit of 4 frames: 23, 5, 6, 8); FD 79 of 10 frames",
        "Classic frames of 8.1.7 and 00000000/181/00; FD 01E38787/6AE/F8; 11F38787/6A8/3C; "
        "1079C1E1/6BE/1E; 083DF0F0/69F/0F; 041EF878/68F/87; 1F0C3C3C/683/C3; 0F861E1E/6A3/E1; "
        "07C30F0F/6A1/F0; "
        "1C3FC3C3/6A0/-; 020FE1FF/6B0/-; other bytes 55.",
        "One stuff bit inverted for the IUT.",
        "As 8.2.3.",
    ),
    Purpose(
        "8.2.5",
        T,
        "A transmitter sees a form error at each bit of fixed form.",
        ALL,
        "classic 5: CRC delimiter, ACK delimiter, EOF bits 1, 4, 7; FD the same 5 and the fixed stuff "
        "bits of CRC-17 (6) and CRC-21 (7)",
        "IUT sends a frame, LT acknowledges (FD, ACK delimiter test: two dominant ACK bits).",
        "That bit inverted for the IUT.",
        "Active flag from the next bit; the frame is repeated.",
        "The count of FD tests is 16 in one place, 18 in another. 'Two ACK bits used' in the ACK "
        "delimiter test says that one is the usual case: with one ACK bit the dominant delimiter would "
        "be tolerated as the second.",
    ),
    Purpose(
        "8.2.6",
        T,
        "A recessive ACK slot is an acknowledgement error.",
        ALL,
        "classic 1; FD 1",
        "IUT sends a base frame.",
        "Nobody acknowledges; FD: two recessive bits behind the CRC delimiter.",
        "Classic: active flag in the bit behind the ACK slot. FD: in the bit behind the two-bit ACK "
        "slot, the third behind the CRC delimiter. Frame repeated behind the intermission.",
        "The FD place is the same with both readings of the slot.",
    ),
    Purpose(
        "8.2.7",
        T,
        "An FD transmitter accepts a late acknowledge and one of two bits.",
        FD,
        "2: CRC delimiter of two bits (ACK one bit late); ACK of two bits",
        "IUT sends an FD frame.",
        "1: first bit behind the CRC delimiter recessive, second dominant. 2: both dominant.",
        "No flag; the frame is valid; EOF and intermission follow the later bit.",
        "In case 1 and 2 the frame is one bit longer than with a one-bit ACK; with a fixed two-bit slot "
        "it is not.",
    ),
    Purpose(
        "8.2.8",
        T,
        "A transmitter sees a disturbed stuff bit at each position of a 64-byte data field.",
        FD,
        "1008: 8 frames x 126 stuff bits",
        f"IUT sends: {STUFF_64}. TEC set to 0 before each.",
        "One stuff bit inverted for the IUT, 1 data bit.",
        "Active flag, nominal rate, from the next bit; repeated (single shot may be used to save time).",
    ),
)
