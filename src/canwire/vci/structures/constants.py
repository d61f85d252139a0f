"""The CAN constants of cantype.h, with their names; flags can be combined with OR.

Bus and controller types: controller_types.py. Bit timings for ICanControl2: vci/can/presets.py.
Source: cantype.h of VCI 4.1; VCI V4 manual 5.2.2, 5.2.3, 5.2.5 and 7.3;
reference/vci.md section 3.
"""

from __future__ import annotations

# operating mode: CANINITLINE.bOpMode
CAN_OPMODE_UNDEFINED = 0x00
CAN_OPMODE_STANDARD = 0x01  # 11-bit identifiers
CAN_OPMODE_EXTENDED = 0x02  # 29-bit identifiers
CAN_OPMODE_ERRFRAME = 0x04  # report error frames as messages
CAN_OPMODE_LISTONLY = 0x08
CAN_OPMODE_LOWSPEED = 0x10  # fault-tolerant bus coupling
CAN_OPMODE_AUTOBAUD = 0x20

# extended operating mode: CANINITLINE2.bExMode
CAN_EXMODE_DISABLED = 0x00
CAN_EXMODE_EXTDATA = 0x01  # up to 64 bytes of data
CAN_EXMODE_FASTDATA = 0x02  # second bit rate for the data
CAN_EXMODE_NONISO = 0x04

# bit timing mode: CANBTP.dwMode
CAN_BTMODE_RAW = 0x01  # register values of the controller instead of bit/s and ratios
CAN_BTMODE_TSM = 0x02  # triple sampling

# bus coupling: CANCAPABILITIES.wBusCoupling
CAN_BUSC_UNDEFINED = 0x0000
CAN_BUSC_LOWSPEED = 0x0001
CAN_BUSC_HIGHSPEED = 0x0002

# state of the controller: CANLINESTATUS.dwStatus
CAN_STATUS_TXPEND = 0x01  # a frame waits or is being sent
CAN_STATUS_OVRRUN = 0x02  # the controller lost received frames
CAN_STATUS_ERRLIM = 0x04  # an error counter passed the warning limit
CAN_STATUS_BUSOFF = 0x08
CAN_STATUS_ININIT = 0x10  # stopped
CAN_STATUS_BUSCERR = 0x20  # fault of the low-speed coupling

# what a controller can do: CANCAPABILITIES.dwFeatures
CAN_FEATURE_STDOREXT = 0x00001  # 11 or 29 bits, not both at the same time
CAN_FEATURE_STDANDEXT = 0x00002  # both at the same time
CAN_FEATURE_RMTFRAME = 0x00004
CAN_FEATURE_ERRFRAME = 0x00008
CAN_FEATURE_BUSLOAD = 0x00010
CAN_FEATURE_IDFILTER = 0x00020  # exact filtering
CAN_FEATURE_LISTONLY = 0x00040
CAN_FEATURE_SCHEDULER = 0x00080  # cyclic transmit list
CAN_FEATURE_GENERRFRM = 0x00100  # sends error frames
CAN_FEATURE_DELAYEDTX = 0x00200
CAN_FEATURE_SINGLESHOT = 0x00400
CAN_FEATURE_HIGHPRIOR = 0x00800
CAN_FEATURE_AUTOBAUD = 0x01000  # VCI 3 has CAN FD at this bit
CAN_FEATURE_EXTDATA = 0x02000
CAN_FEATURE_FASTDATA = 0x04000
CAN_FEATURE_ISOFRAME = 0x08000
CAN_FEATURE_NONISOFRM = 0x10000
CAN_FEATURE_64BITTSC = 0x20000  # 64-bit time stamps

# filters: which one, in which mode, for how many identifiers
CAN_FILTER_STD = 1
CAN_FILTER_EXT = 2
CAN_FILTER_VOID = 0x00  # no mode
CAN_FILTER_LOCK = 0x01  # nothing passes
CAN_FILTER_PASS = 0x02  # everything passes
CAN_FILTER_INCL = 0x03  # registered identifiers pass
CAN_FILTER_EXCL = 0x04  # registered identifiers do not
CAN_FILTER_SRRA = 0x80  # flag for ICanChannel2.Initialize: all channels' self-receptions count as traffic
CAN_FILTER_SIZE_STD = 2048
CAN_FILTER_SIZE_EXT = 2048

# acceptance filter: code is identifier << 1 | rtr, a mask bit of 1 compares
CAN_ACC_MASK_ALL = 0x00000000
CAN_ACC_CODE_ALL = 0x00000000
CAN_ACC_MASK_NONE = 0xFFFFFFFF
CAN_ACC_CODE_NONE = 0x80000000  # no message has that bit, so nothing matches

# message type: CANMSGINFO.Bits.type
CAN_MSGTYPE_DATA = 0
CAN_MSGTYPE_INFO = 1
CAN_MSGTYPE_ERROR = 2
CAN_MSGTYPE_STATUS = 3
CAN_MSGTYPE_WAKEUP = 4  # not used
CAN_MSGTYPE_TIMEOVR = 5  # the time stamp counter wrapped around
CAN_MSGTYPE_TIMERST = 6  # not used

# identifiers: CANMSG.dwMsgId
CAN_MSGID_MASK11 = 0x000007FF
CAN_MSGID_MASK29 = 0x1FFFFFFF
CAN_MSGID_INVALID = 0xE0000000
CAN_MSGID_INFO = 0xFFFFFFFF
CAN_MSGID_ERROR = 0xFFFFFFFF
CAN_MSGID_STATUS = 0xFFFFFFFF
CAN_MSGID_WAKEUP = 0xFFFFFFFF

# abData[0] of CAN_MSGTYPE_INFO
CAN_INFO_START = 1
CAN_INFO_STOP = 2
CAN_INFO_RESET = 3

# abData[0] of CAN_MSGTYPE_ERROR
CAN_ERROR_NONE = 0
CAN_ERROR_STUFF = 1
CAN_ERROR_FORM = 2
CAN_ERROR_ACK = 3
CAN_ERROR_BIT = 4
CAN_ERROR_FDB = 5  # bit error at the fast data bit rate
CAN_ERROR_CRC = 6
CAN_ERROR_DLC = 7
CAN_ERROR_OTHER = 8

# the filter that accepted a message: CANMSGINFO.Bits.afc
CAN_ACCEPT_REJECT = 0x00
CAN_ACCEPT_FILTER_1 = 0x01  # the acceptance filter
CAN_ACCEPT_FILTER_2 = 0x02  # the list of identifiers
CAN_ACCEPT_PASSEXCL = 0x03  # an excluding filter
CAN_ACCEPT_ALWAYS = 0xFF  # no data message: filters do not apply

# bits of CANMSGINFO.Bytes.bFlags and .bFlags2
CAN_MSGFLAGS_DLC = 0x0F
CAN_MSGFLAGS_OVR = 0x10
CAN_MSGFLAGS_SRR = 0x20
CAN_MSGFLAGS_RTR = 0x40
CAN_MSGFLAGS_EXT = 0x80
CAN_MSGFLAGS2_SSM = 0x01
CAN_MSGFLAGS2_HPM = 0x02
CAN_MSGFLAGS2_EDL = 0x04
CAN_MSGFLAGS2_FDR = 0x08
CAN_MSGFLAGS2_ESI = 0x10
CAN_MSGFLAGS2_RES = 0xE0

# cyclic transmit list
CAN_MAX_CTX_MSGS = 16
CAN_CTXMSG_INC_NO = 0
CAN_CTXMSG_INC_ID = 1  # the identifier counts up
CAN_CTXMSG_INC_8 = 2  # a byte of the data counts up
CAN_CTXMSG_INC_16 = 3  # two bytes, the low one first
CAN_CTXTSK_STAT_STOPPED = 0
CAN_CTXTSK_STAT_RUNNING = 1
CAN_CTXMSG_STAT_EMPTY = 0
CAN_CTXMSG_STAT_BUSY = 1
CAN_CTXMSG_STAT_DONE = 2

# what is locked: CANRTINFO.dwLockStatus
CAN_RTI_LOCKSTAT_CTL = 0x00000001  # ICanControl
CAN_RTI_LOCKSTAT_SHD = 0x00000002  # ICanScheduler
CAN_RTI_LOCKSTAT_CHN = 0x80000000  # a channel is exclusive

# data length code: S classic, E extended (CAN FD)
CAN_SDLC_MAX = 8
CAN_SLEN_MAX = 8
CAN_EDLC_MAX = 15
CAN_ELEN_MAX = 64
CAN_EDLC_XLT = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)
CAN_ELEN_XLT = tuple(sum(room < length for room in CAN_EDLC_XLT) for length in range(CAN_ELEN_MAX + 1))

# tables for DetectBaud; the header writes TABEL
CAN_BTR_TABLE_SIZE = 64
CAN_BTP_TABLE_SIZE = 64
CAN_BTR_TABEL_SIZE = CAN_BTR_TABLE_SIZE
CAN_BTP_TABEL_SIZE = CAN_BTP_TABLE_SIZE

# SJA1000 bus timing registers at 16 MHz; 667 is python-can's, not in the header
CAN_BT0_5KB, CAN_BT1_5KB = 0x3F, 0x7F
CAN_BT0_10KB, CAN_BT1_10KB = 0x31, 0x1C
CAN_BT0_20KB, CAN_BT1_20KB = 0x18, 0x1C
CAN_BT0_50KB, CAN_BT1_50KB = 0x09, 0x1C
CAN_BT0_100KB, CAN_BT1_100KB = 0x04, 0x1C
CAN_BT0_125KB, CAN_BT1_125KB = 0x03, 0x1C
CAN_BT0_250KB, CAN_BT1_250KB = 0x01, 0x1C
CAN_BT0_500KB, CAN_BT1_500KB = 0x00, 0x1C
CAN_BT0_667KB, CAN_BT1_667KB = 0x00, 0x18
CAN_BT0_800KB, CAN_BT1_800KB = 0x00, 0x16
CAN_BT0_1000KB, CAN_BT1_1000KB = 0x00, 0x14

# misprints of the manual, so that code copied from it runs
CAN_FEATURE_STDREXT = CAN_FEATURE_STDOREXT
CAN_FEATURE_STDANEXT = CAN_FEATURE_STDANDEXT
CAN_FEATURE_SINGLESOT = CAN_FEATURE_SINGLESHOT
CAN_FILTER_SRR = CAN_FILTER_SRRA
CAN_ACCEPT_FILTER1 = CAN_ACCEPT_FILTER_1
CAN_ACCEPT_FILTER2 = CAN_ACCEPT_FILTER_2
CAN_ACCEPT_EXCL = CAN_ACCEPT_PASSEXCL
DCAN_STATUS_BUSCERR = CAN_STATUS_BUSCERR


def can_make_msgflags(dlc: int, ovr: int, srr: int, rtr: int, ext: int) -> int:
    """CAN_MAKE_MSGFLAGS: the byte CANMSGINFO.Bytes.bFlags."""
    return (ext & 1) << 7 | (rtr & 1) << 6 | (srr & 1) << 5 | (ovr & 1) << 4 | dlc & 0x0F


def can_make_msgflags2(ssm: int, hpm: int, edl: int, fdr: int, esi: int) -> int:
    """CAN_MAKE_MSGFLAGS2: the byte CANMSGINFO.Bytes.bFlags2."""
    return (esi & 1) << 4 | (fdr & 1) << 3 | (edl & 1) << 2 | (hpm & 1) << 1 | ssm & 1


def can_sdlc_to_len(dlc: int) -> int:
    """CAN_SDLC_TO_LEN: the number of bytes of a classic frame; 8 for each code out of range."""
    return dlc if 0 <= dlc <= CAN_SDLC_MAX else CAN_SLEN_MAX


def can_edlc_to_len(dlc: int) -> int:
    """CAN_EDLC_TO_LEN: the number of bytes of a CAN FD frame; 64 for each code out of range."""
    return CAN_EDLC_XLT[dlc] if 0 <= dlc <= CAN_EDLC_MAX else CAN_ELEN_MAX


def can_len_to_sdlc(length: int) -> int:
    """CAN_LEN_TO_SDLC: the data length code of a classic frame; 8 for each length out of range."""
    return length if 0 <= length <= CAN_SLEN_MAX else CAN_SDLC_MAX


def can_len_to_edlc(length: int) -> int:
    """CAN_LEN_TO_EDLC: the smallest CAN FD code with room for `length` bytes; 15 for each length out of range."""
    return CAN_ELEN_XLT[length] if 0 <= length <= CAN_ELEN_MAX else CAN_EDLC_MAX
