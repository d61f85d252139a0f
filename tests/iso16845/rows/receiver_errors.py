"""Rows of chapters 7.2 receiver: detection of errors."""

from __future__ import annotations

from tests.iso16845.rows.terms import ALL, FD, STUFF_64, Purpose, R

ROWS: tuple[Purpose, ...] = (
    Purpose(
        "7.2.1",
        R,
        "A receiver sees a bit error when its own acknowledge is made recessive.",
        ALL,
        "1",
        "LT sends a valid frame.",
        "ACK slot forced recessive for the IUT, 1 bit.",
        "Active error flag from the bit behind the ACK slot.",
        "FD: same place, the bit behind the first ACK bit.",
    ),
    Purpose(
        "7.2.2",
        R,
        "A receiver sees a stuff error at any stuff bit of a base-format frame up to the CRC delimiter.",
        ALL,
        "every stuff bit of 10 frames, one a test (classic; FD tolerant; FD enabled with FD frames)",
        "Frames of 7.1.10 (FD tolerant frame 3 with 8x87). FD: byte 0 as there, all other bytes 55.",
        "One stuff bit inverted, 1 bit; REC set back to 0 between tests.",
        "Active error flag from the bit behind it; no ACK.",
        "In FD frames no dynamic stuff bit follows the last data bit: there the first fixed stuff bit "
        "takes its place.",
    ),
    Purpose(
        "7.2.2.a",
        R,
        "As 7.2.2 with an error-passive IUT.",
        ALL,
        "as 7.2.2",
        "IUT passive, else as 7.2.2.",
        "One stuff bit inverted, 1 bit.",
        "Passive error flag (IUT drives recessive) from the bit behind it; no ACK, frame not handed up.",
        "Not a purpose of the standard; an addition of the public library.",
    ),
    Purpose(
        "7.2.2.b",
        R,
        "As 7.2.2 in restricted operation.",
        ALL,
        "as 7.2.2",
        "IUT in restricted operation, else as 7.2.2.",
        "One stuff bit inverted, then 11 recessive bits.",
        "No flag; IUT drives recessive, integrates, is idle after 11 recessive bits; REC, TEC unchanged.",
        "Not a purpose of the standard; an addition of the public library. Needs restricted operation. "
        "Only the text of 7.2.4.b was read.",
    ),
    Purpose(
        "7.2.3",
        R,
        "A receiver sees a stuff error at any stuff bit of an extended-format frame.",
        ALL,
        "every stuff bit of 8 classic (FD tolerant) / 11 FD frames, one a test",
        "Frames of 7.1.11, classic ones plus 00000000/181/00; FD: byte 0 as there, all others 55.",
        "One stuff bit inverted, 1 bit; REC set back to 0 between tests.",
        "Active error flag from the bit behind it; no ACK.",
        "The public description of the response is that of 7.1.11 by mistake; the error flag is what is "
        "checked.",
    ),
    Purpose(
        "7.2.3.a",
        R,
        "As 7.2.3 with an error-passive IUT.",
        ALL,
        "as 7.2.3",
        "IUT passive, else as 7.2.3.",
        "One stuff bit inverted, 1 bit.",
        "Passive error flag from the bit behind it; no ACK, frame not handed up.",
        "Not a purpose of the standard; an addition of the public library.",
    ),
    Purpose(
        "7.2.3.b",
        R,
        "As 7.2.3 in restricted operation.",
        ALL,
        "as 7.2.3",
        "IUT in restricted operation, else as 7.2.3.",
        "One stuff bit inverted, then 11 recessive bits.",
        "No flag; IUT drives recessive, integrates, is idle after 11 recessive bits; REC, TEC unchanged.",
        "Not a purpose of the standard; an addition of the public library. Needs restricted operation. "
        "Only the text of 7.2.4.b was read.",
    ),
    Purpose(
        "7.2.4",
        R,
        "A receiver sees a stuff error at each stuff-bit position of a 64-byte data field.",
        FD,
        "1008: 8 frames x 126 stuff bits",
        f"{STUFF_64}.",
        "One stuff bit inverted, 1 data bit; REC set back to 0 between tests.",
        "Active error flag, at the nominal rate, from the bit behind it.",
    ),
    Purpose(
        "7.2.4.a",
        R,
        "As 7.2.4 with an error-passive IUT.",
        FD,
        "1008",
        "IUT passive, else as 7.2.4.",
        "One stuff bit inverted, 1 data bit.",
        "Passive error flag from the bit behind it.",
        "Not a purpose of the standard; an addition of the public library.",
    ),
    Purpose(
        "7.2.4.b",
        R,
        "As 7.2.4 in restricted operation.",
        FD,
        "1008",
        "IUT in restricted operation, else as 7.2.4.",
        "One stuff bit inverted; the rest of the frame replaced by 11 recessive nominal bits.",
        "No flag, IUT drives recessive throughout, integrates; REC unchanged.",
        "Not a purpose of the standard; an addition of the public library. Needs restricted operation.",
    ),
    Purpose(
        "7.2.5",
        R,
        "The CRC of the frame's own format is checked; a CRC error is flagged at the right place and a "
        "dominant ACK "
        "by others is no error.",
        ALL,
        "classic 3: a dominant CRC bit made recessive; a recessive one made dominant; SOF made recessive "
        "with ID 001. FD 6: the first two "
        "each for CRC-17 and CRC-21; two stuff bits turned data bits by lost bits while the CRC register "
        "is 0 (stuff count); parity bit of the "
        "stuff count and the fixed stuff bit behind it inverted",
        "LT sends the altered frame (CRC altered where no stuff bit is hit and none follows; later bits "
        "restuffed to fit).",
        "As listed.",
        "No ACK by the IUT. Classic: active flag in the bit behind the ACK delimiter. FD: in the fourth "
        "bit behind the CRC delimiter; frame not handed up.",
        "Fourth bit = two ACK bits + ACK delimiter; with a one-bit slot it is the third. Test 5 is not "
        "done by the public library: lose one of five "
        "equal bits by a shift of the edges twice, so that both stuff bits count as data and the CRC "
        "still fits. LT may send the ACK dominant.",
    ),
    Purpose(
        "7.2.6",
        R,
        "CRC error and dominant CRC delimiter together give one flag, at the delimiter.",
        ALL,
        "classic 1; FD 2 (CRC-17, CRC-21)",
        "LT sends a frame with one wrong CRC bit.",
        "CRC delimiter forced dominant.",
        "One active error flag of 6 bits from the bit behind the CRC delimiter, no second one.",
    ),
    Purpose(
        "7.2.7",
        R,
        "A dominant CRC delimiter is a form error.",
        ALL,
        "1",
        "LT sends an otherwise valid frame.",
        "CRC delimiter forced dominant.",
        "Active error flag from the bit behind it.",
    ),
    Purpose(
        "7.2.8",
        R,
        "A fixed stuff bit equal to its predecessor is a form error.",
        FD,
        "recessive and dominant fixed stuff bits of CRC-17 (6 bits) and CRC-21 (7 bits), each bit once; "
        "the plan counts 22",
        "LT sends FD frames with DLC <= 10 and > 10.",
        "One fixed stuff bit inverted.",
        "Active error flag from the bit behind it.",
        "6 + 7 bits in both polarities would be 26; how 22 are counted is unclear. Take all positions "
        "with both values.",
    ),
    Purpose(
        "7.2.9",
        R,
        "A dominant ACK delimiter is a form error.",
        ALL,
        "1",
        "LT sends a valid frame.",
        "ACK delimiter forced dominant. FD: ACK slot, second ACK bit and the bit behind it all dominant.",
        "Active error flag from the bit behind the ACK delimiter.",
        "FD: third dominant bit behind the CRC delimiter is the error; same with either reading of the slot.",
    ),
    Purpose(
        "7.2.10",
        R,
        "A dominant bit in the EOF is a form error.",
        ALL,
        "5: EOF bits 1..5",
        "LT sends a valid frame.",
        "One EOF bit forced dominant.",
        "Active error flag from the bit behind it; frame not handed up.",
    ),
    Purpose(
        "7.2.11",
        R,
        "Up to the sixth EOF bit a frame can still become invalid for a receiver.",
        ALL,
        "1",
        "Reception buffer holds other data. LT sends a valid frame.",
        "EOF bit 6 forced dominant.",
        "Active error flag from EOF bit 7; nothing handed up, buffer unchanged.",
    ),
)
