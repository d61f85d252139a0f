"""Rows of chapters 7.1 receiver: valid frames."""

from __future__ import annotations

from tests.iso16845.rows.terms import (
    ALL,
    FD_AWARE,
    IDS,
    IDS_EXT,
    STUFF_BASE_CLASSIC,
    STUFF_BASE_FD,
    STUFF_BASE_TOLERANT,
    STUFF_EXT_CLASSIC,
    STUFF_EXT_FD,
    STUFF_EXT_TOLERANT,
    Purpose,
    R,
)

ROWS: tuple[Purpose, ...] = (
    Purpose(
        "7.1.1",
        R,
        "A receiver takes correct base-format data frames of any identifier and any number of data bytes.",
        ALL,
        f"classic {IDS} x DLC 0..8 = 45; FD {IDS} x all 16 DLC = 80",
        "Default state; LT sends one frame a test.",
        "None.",
        "No error flag; dominant ACK; identifier, DLC and data handed up as sent; REC unchanged.",
    ),
    Purpose(
        "7.1.2",
        R,
        "The same for extended-format data frames.",
        ALL,
        f"classic {IDS_EXT} x DLC 0..8 = 45; FD {IDS_EXT} x all 16 DLC = 80",
        "Default state; LT sends one frame a test.",
        "None.",
        "No error flag; dominant ACK; identifier, DLC and data handed up as sent.",
    ),
    Purpose(
        "7.1.3",
        R,
        "An IUT that loses arbitration receives the winner's frame and then repeats its own.",
        ALL,
        "6 with classic frames; 4 more mixing classic and FD (FD enabled)",
        "IUT and LT start together, same leading bits, DLC 0. LT format / IUT format / bit where the IUT "
        "loses: CBFF/CBFF/RTR "
        "(IUT remote); CBFF/CEFF/SRR; CBFF remote/CEFF/IDE; CEFF/CBFF/last base-ID bit; CEFF/CEFF/last "
        "extension bit; "
        "CEFF/CEFF/RTR (IUT remote). FD enabled: CBFF/FBFF/last base-ID bit; FBFF/CBFF remote/RTR; "
        "CEFF/FEFF/last extension bit; "
        "FEFF/CEFF remote/RTR.",
        "LT sends dominant where the IUT sends recessive, then its own valid frame.",
        "IUT turns receiver at that sample, drives recessive, acknowledges and hands up LT's frame; no "
        "error flag; its own frame "
        "starts in the bit behind the third intermission bit, complete and unchanged.",
    ),
    Purpose(
        "7.1.4",
        R,
        "A receiver tolerates the other value of a reserved bit in a base-format frame.",
        ("classic", "FD enabled"),
        "1 each",
        "Default state. Classic-only IUT: CBFF with the FDF position (r0) recessive. FD enabled: FBFF "
        "with RRS recessive.",
        "The bit is sent recessive with a CRC that fits it.",
        "No error flag; dominant ACK; data as sent. A classic-only IUT reads the rest as a classic frame.",
        "A classic-only controller that is FD tolerant is covered by 7.1.6 instead.",
    ),
    Purpose(
        "7.1.5",
        R,
        "The same in extended format for SRR and the reserved bits.",
        ALL,
        "classic 7 (SRR,r0,FDF = 111 110 101 011 010 001 000); FD tolerant 3 (SRR,r0 = 11 01 00, FDF 0); "
        "FD enabled 3 (SRR,RRS = 11 01 00, FDF 1)",
        "Default state; LT sends one extended data frame a test with these bits and a fitting CRC.",
        "As listed.",
        "No error flag; dominant ACK; data as sent.",
    ),
    Purpose(
        "7.1.6",
        R,
        "A bit that no known format has makes the IUT leave the frame quietly (protocol exception) until "
        "the bus "
        "is free, whatever the data rate does meanwhile.",
        FD_AWARE,
        "3: FBFF DLC 10 data all AA rate 1:2; FBFF DLC 15 data all FF rate 1:8; CBFF-length frame DLC 15 "
        "data all FF",
        "Protocol exception handling on. LT sends a frame with FDF 1 (FD tolerant) or FDF 1 and res 1 "
        "(FD enabled), then at once, "
        "behind the third intermission bit, a valid classic frame.",
        "Bit rate switches behind BRS in tests 1 and 2.",
        "No error flag and no ACK in the first frame, REC and TEC unchanged; 11 recessive nominal bits "
        "(ACK delimiter, EOF, "
        "intermission) end the exception; the classic frame is acknowledged and handed up.",
        "How test 3 (classic frame format, FD enabled) comes to an exception is unclear; the public "
        "library runs 2 tests there. "
        "Each edge must restart the count of recessive bits. LT must send the ACK slot dominant, else "
        "the count begins earlier.",
    ),
    Purpose(
        "7.1.7",
        R,
        "The end of a protocol exception is counted exactly: 11 recessive bits.",
        FD_AWARE,
        "3: next SOF after intermission + 1 bit; right after intermission bit 3; right after "
        "intermission bit 2 and a third "
        "frame after that one's full intermission",
        "Protocol exception handling on. LT sends a frame as in 7.1.6 with a dominant ACK slot, then "
        "valid classic frames.",
        "Frame spacing as listed: 12, 11 and 10 recessive bits from the ACK delimiter on.",
        "No error flag anywhere. Tests 1 and 2: second frame acknowledged and received. Test 3: second "
        "frame neither acknowledged nor "
        "received (10 bits do not end the exception), third one both.",
        "If LT's FD frame has a second ACK bit it must be dominant too, so that the recessive run starts "
        "at the ACK delimiter.",
    ),
    Purpose(
        "7.1.8",
        R,
        "A classic DLC above 8 means 8 data bytes and is kept.",
        ALL,
        "7: DLC 9..15, classic frames only",
        "Default state; LT sends a classic data frame with 8 data bytes.",
        "None.",
        "No error flag; dominant ACK; DLC code and 8 bytes handed up.",
    ),
    Purpose(
        "7.1.9",
        R,
        "A receiver takes frames that follow each other without bus idle.",
        ALL,
        "2: second SOF after intermission bit 2; after intermission bit 3",
        "LT sends two different frames.",
        "Spacing as listed.",
        "No error flag, no overload flag; both acknowledged and handed up.",
    ),
    Purpose(
        "7.1.10",
        R,
        "A receiver removes stuff bits correctly in base format.",
        ALL,
        "10 frames each: classic, FD tolerant/enabled classic, FD enabled FD",
        f"Classic: {STUFF_BASE_CLASSIC}. FD tolerant and FD enabled: {STUFF_BASE_TOLERANT}. FD frames: "
        f"{STUFF_BASE_FD}.",
        "None.",
        "No error flag; dominant ACK; data as sent.",
        "CTRL 28F means RRS recessive.",
    ),
    Purpose(
        "7.1.11",
        R,
        "A receiver removes stuff bits correctly in extended format.",
        ALL,
        "classic 7, FD tolerant 7, FD enabled 11 FD frames",
        f"Classic: {STUFF_EXT_CLASSIC}. FD tolerant and FD enabled: {STUFF_EXT_TOLERANT}. FD frames: "
        f"{STUFF_EXT_FD}.",
        "None.",
        "No error flag; dominant ACK; data as sent.",
        "CTRL 2A8 means SRR dominant; 3A0 and 380 SRR dominant and RRS recessive.",
    ),
    Purpose(
        "7.1.12",
        R,
        "For a receiver a frame is valid from the last but one EOF bit on.",
        ALL,
        "1",
        "LT sends a valid frame.",
        "EOF bit 7 forced dominant, 1 bit.",
        "Dominant ACK; no error flag; overload flag in the bit behind EOF; data handed up.",
    ),
)
