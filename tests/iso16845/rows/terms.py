"""Test purposes of ISO 16845-1 (CAN data link layer, conformance test plan), in our own words.

Conventions. IUT: the controller under test. LT: the lower tester, here everything else on the bus, which
may also
force the level that the IUT sees (one node's level) for any span of time.
Bits of a field, flag or delimiter are counted from 1 in the order on the wire, stuff bits included. Time
quanta (tq) of
a bit are counted from 1 (tq 1 = SYNC). N nominal, D data phase. Sync, Prop, PS1, PS2: the segments; NTQ:
quanta a bit;
SJW: jump width. "Dominant up to the sample point" means the last dominant quantum ends there: an ideal
simulator
keeps 1 minimum quantum clear of the instant itself.
Frame E: base format, one data byte 0x80, so that bit 7 of the data field on the wire is a recessive stuff
bit; forcing it
dominant gives a stuff error for a receiver and a bit error for a transmitter, both flags begin in bit 8 of
the data field.
Frame S: base format, ID 0x7FF, so that bits 6 and 12 on the wire behind SOF are dominant stuff bits in the
identifier.
Frame D7: FD, BRS = 1, one data byte 0x7F: bit 7 of the data field is a dominant stuff bit.
Frame format names: CBFF, CEFF classic base / extended; FBFF, FEFF the FD ones.
CTRL values (hexadecimal) of the stuffing tables. Base classic: RTR IDE FDF DLC(4). Base FD: RRS IDE FDF res
BRS ESI DLC(4).
Extended classic: SRR IDE RTR FDF r0 DLC(4). Extended FD: SRR IDE RRS FDF res BRS ESI DLC(4).
"Default state": on the bus, idle, error active, TEC = REC = 0. "Passive": TEC >= 128 (LT has made it so, or
it is preset).
Each row whose `applies` names FD enabled is run with classic frames by every controller and once more with
FD frames by
FD-enabled ones, unless `elementary` says otherwise.
ACK: FD rows are written for "ACK slot of one bit, a second dominant one tolerated"; notes say where two
bits change them.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

Side = Literal["receiver", "transmitter"]
Kind = Literal["classic", "FD tolerant", "FD enabled"]


class Purpose(NamedTuple):
    """One test purpose; `elementary` is the count or the rule that gives it."""

    number: str
    side: Side
    purpose: str
    applies: tuple[Kind, ...]
    elementary: str
    setup: str
    disturbance: str
    expected: str
    note: str = ""


ALL: tuple[Kind, ...] = ("classic", "FD tolerant", "FD enabled")
FD: tuple[Kind, ...] = ("FD enabled",)
FD_AWARE: tuple[Kind, ...] = ("FD tolerant", "FD enabled")
R: Side = "receiver"
T: Side = "transmitter"

STUFF_BASE_CLASSIC = (
    "ID/CTRL/data: 078/08/01 then 7xE1; 41F/01/00; 707/1F/8x0F; 360/10/-; 730/10/-; 47F/01/1F; 758/00/-; "
    "777/01/1F; 7EF/42/- (remote, DLC 2); 3EA/5F/- (remote, DLC 15)"
)
STUFF_BASE_TOLERANT = "the same with FDF 0 (CTRL 0F, 00, 00, 4F in frames 3, 4, 5, 10)"
STUFF_BASE_FD = (
    "078/0AE/F8 then 47x78; 47C/0A8/8x3C; 41E/0BE/48x1E; 20F/09F/64x0F; 107/28F/64x87; 7C3/083/3xC3; "
    "3E1/0A3/3xE1; "
    "1F0/0A1/F0; 000/0A0/-; 7FF/0B0/-"
)
STUFF_EXT_CLASSIC = (
    "ID/CTRL/data: 07C30F0F/188/8x3C; 07C0F0F0/181/00; 01E31717/19F/8x0F; "
    "01E00FF0/1BC/1F 0F E0 F0 7F E0 FF 20; 1FB80000/181/A0; 00BC540F/1E0/- (remote); 155D5557/1FF/- (remote)"
)
STUFF_EXT_TOLERANT = "the same with FDF 0 (CTRL 19C, 1C0, 1DF in frames 4, 6, 7)"
STUFF_EXT_FD = (
    "01E38787/6AE/F8 then 47x78; 11F3C3C3/2A8/8x3C; 1079C1E1/6BE/48x1E; 083DF0F0/69F/64x0F; "
    "041EF878/68F/64x87; "
    "1F0C3C3C/683/3xC3; 0F861E1E/6A3/3xE1; 07C30F0F/6A1/F0; 01E38787/3A0/-; 11F3C3C3/380/-; 00000000/6B0/-"
)
STUFF_64 = (
    "FBFF, ID 555, DLC 15, BRS 1; byte 0 / bytes 1..63: 10/78, 78/3C, 34/1E, 12/0F, 0F/87, 17/C3, "
    "43/E1, 21/F0, "
    "each with 126 stuff-bit places (in 12/0F and 21/F0 the last is the first fixed stuff bit)"
)
RX_E = "LT sends frame E to the default-state IUT and forces bit 7 of the data field dominant: active flag from bit 8."
RX_E_PASSIVE = (
    "IUT passive. LT sends frame E and forces bit 7 of the data field dominant: passive flag from bit 8."
)
TX_E = "IUT sends frame E; LT forces bit 7 of the data field dominant: bit error, active flag from bit 8."
TX_E_PASSIVE = (
    "IUT passive, sends frame E (ESI 1 in FD); LT forces data bit 7 dominant: passive flag from bit 8."
)
RX_OVERLOAD = (
    "LT sends a valid frame and forces the last EOF bit dominant: IUT's overload flag starts in the next bit."
)
TX_OVERLOAD = (
    "IUT sends a frame, LT acknowledges it and forces intermission bit 1 dominant: overload flag from bit 2."
)
IDS = "5 IDs (555, 2AA, 000, 7FF, one random)"
IDS_EXT = "5 IDs (15555555, 0AAAAAAA, 00000000, 1FFFFFFF, one random)"
EACH_E = "one for each e, for at least one bit rate"
EACH_SP_N = "one for each programmable nominal sample point (constant NTQ), for at least one bit rate"
EACH_SP_D = "one for each programmable data-phase sample point (constant NTQ(D)), for at least one bit rate"
ACK_2 = "With a two-bit ACK slot in FD everything behind the ACK slot comes one bit later."
