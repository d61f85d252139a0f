"""The enumerations of V3's CAN part, in Python's spelling; flags can be combined with OR.

They are similar to those of lin/enums.py, but mean other bits.

Values are V4's, except that V3 has other numbers in CanMsgError, has CAN FD at bit 12 of CanFeatures, and has neither
CAN_OPMODE_AUTOBAUD nor CAN_ACCEPT_PASSEXCL.
Source: VCI V3 .NET manual 4.2; reference/vci.md sections 2, 3 and 7a.
"""

from __future__ import annotations

from enum import IntEnum, IntFlag

from canwire.vci import controller_types as t
from canwire.vci.structures import constants as c


class CanCtrlType(IntEnum):
    """The kind of CAN controller; a kind that is not in V3 is UNKNOWN."""

    UNKNOWN = t.CAN_CTRL_UNKNOWN
    INTEL_82527 = t.CAN_CTRL_82527
    INTEL_82C200 = t.CAN_CTRL_82C200
    INTEL_81C90 = t.CAN_CTRL_81C90
    INTEL_81C92 = t.CAN_CTRL_81C92
    SJA1000 = t.CAN_CTRL_SJA1000
    INFINEON_82C900 = t.CAN_CTRL_82C900
    TOUCAN = t.CAN_CTRL_TOUCAN
    MSCAN = t.CAN_CTRL_MSCAN
    FLEXCAN = t.CAN_CTRL_FLEXCAN
    IFI_CAN = t.CAN_CTRL_IFICAN
    C_CAN = t.CAN_CTRL_BCCAN
    BXCAN = t.CAN_CTRL_BXCAN
    IFI_CAN_FD = t.CAN_CTRL_IFICFD
    M_CAN = t.CAN_CTRL_BMCAN

    @classmethod
    def _missing_(cls, value: object) -> CanCtrlType:
        return cls.UNKNOWN


class CanBusCouplings(IntFlag):
    """The coupling of a controller to its bus."""

    UNDEFINED = c.CAN_BUSC_UNDEFINED
    LOW_SPEED = c.CAN_BUSC_LOWSPEED
    HIGH_SPEED = c.CAN_BUSC_HIGHSPEED


class CanFeatures(IntFlag):
    """The capabilities of a controller."""

    STD_OR_EXT = c.CAN_FEATURE_STDOREXT  # 11 or 29 bits, not both at the same time
    STD_AND_EXT = c.CAN_FEATURE_STDANDEXT  # both at the same time
    REMOTE_FRAME = c.CAN_FEATURE_RMTFRAME
    ERR_FRAME = c.CAN_FEATURE_ERRFRAME
    BUSLOAD = c.CAN_FEATURE_BUSLOAD
    ID_FILTER = c.CAN_FEATURE_IDFILTER
    LIST_ONLY = c.CAN_FEATURE_LISTONLY
    SCHEDULER = c.CAN_FEATURE_SCHEDULER
    GEN_ERR_FRAME = c.CAN_FEATURE_GENERRFRM
    DELAYED_TX = c.CAN_FEATURE_DELAYEDTX
    SINGLE_SHOT = c.CAN_FEATURE_SINGLESHOT
    HIGH_PRIORITY_MSG = c.CAN_FEATURE_HIGHPRIOR
    CAN_FD = 0x1000  # V4 has CAN_FEATURE_AUTOBAUD there


class CanOperatingModes(IntFlag):
    """The operating mode of a line."""

    UNDEFINED = c.CAN_OPMODE_UNDEFINED
    STANDARD = c.CAN_OPMODE_STANDARD
    EXTENDED = c.CAN_OPMODE_EXTENDED
    MODE_MASK = c.CAN_OPMODE_STANDARD | c.CAN_OPMODE_EXTENDED
    ERR_FRAME = c.CAN_OPMODE_ERRFRAME
    LISTEN_ONLY = c.CAN_OPMODE_LISTONLY
    LOW_SPEED = c.CAN_OPMODE_LOWSPEED


class CanCtrlStatus(IntFlag):
    """State of a controller."""

    TX_PENDING = c.CAN_STATUS_TXPEND
    OVERRUN = c.CAN_STATUS_OVRRUN
    ERR_LIMIT = c.CAN_STATUS_ERRLIM
    BUS_OFF = c.CAN_STATUS_BUSOFF
    IN_INIT = c.CAN_STATUS_ININIT
    BUS_C_ERR = c.CAN_STATUS_BUSCERR


class CanFilter(IntEnum):
    """One of the two filters of a line."""

    STD = c.CAN_FILTER_STD
    EXT = c.CAN_FILTER_EXT


class CanAccMask(IntEnum):
    """Masks for SetAccFilter."""

    ALL = c.CAN_ACC_MASK_ALL
    NONE = c.CAN_ACC_MASK_NONE


class CanAccCode(IntEnum):
    """Codes for SetAccFilter."""

    ALL = c.CAN_ACC_CODE_ALL
    NONE = c.CAN_ACC_CODE_NONE


class CanMsgFrameType(IntEnum):
    """The kind of a message; only DATA can be sent."""

    DATA = c.CAN_MSGTYPE_DATA
    INFO = c.CAN_MSGTYPE_INFO
    ERROR = c.CAN_MSGTYPE_ERROR
    STATUS = c.CAN_MSGTYPE_STATUS
    WAKEUP = c.CAN_MSGTYPE_WAKEUP
    TIME_OVERRUN = c.CAN_MSGTYPE_TIMEOVR
    TIME_RESET = c.CAN_MSGTYPE_TIMERST


class CanMsgInfoValue(IntEnum):
    """Byte 0 of an INFO message: the new state of the controller."""

    START = c.CAN_INFO_START
    STOP = c.CAN_INFO_STOP
    RESET = c.CAN_INFO_RESET


class CanMsgError(IntEnum):
    """Byte 0 of an ERROR message, with V3's numbers."""

    STUFF = c.CAN_ERROR_STUFF
    FORM = c.CAN_ERROR_FORM
    ACKNOWLEDGE = c.CAN_ERROR_ACK
    BIT = c.CAN_ERROR_BIT
    CRC = c.CAN_ERROR_CRC
    OTHER = 7


V3_ERRORS = {
    c.CAN_ERROR_NONE: CanMsgError.OTHER,
    c.CAN_ERROR_STUFF: CanMsgError.STUFF,
    c.CAN_ERROR_FORM: CanMsgError.FORM,
    c.CAN_ERROR_ACK: CanMsgError.ACKNOWLEDGE,
    c.CAN_ERROR_BIT: CanMsgError.BIT,
    c.CAN_ERROR_FDB: CanMsgError.BIT,
    c.CAN_ERROR_CRC: CanMsgError.CRC,
    c.CAN_ERROR_DLC: CanMsgError.OTHER,
    c.CAN_ERROR_OTHER: CanMsgError.OTHER,
}
"""V3's error for V4's CAN_ERROR_: a bit error at the fast rate is BIT, other errors that V3 lacks are OTHER."""


class CanMsgAccReason(IntEnum):
    """The filter that accepted a message; ALWAYS if it passed an excluding filter of V4."""

    REJECT = c.CAN_ACCEPT_REJECT
    FILTER_1 = c.CAN_ACCEPT_FILTER_1
    FILTER_2 = c.CAN_ACCEPT_FILTER_2
    ALWAYS = c.CAN_ACCEPT_ALWAYS

    @classmethod
    def _missing_(cls, value: object) -> CanMsgAccReason:
        return cls.ALWAYS


class CanCyclicTXIncMode(IntEnum):
    """The part of a cyclic message that is incremented after each transmission."""

    NO_INC = c.CAN_CTXMSG_INC_NO
    INC_ID = c.CAN_CTXMSG_INC_ID
    INC_8 = c.CAN_CTXMSG_INC_8
    INC_16 = c.CAN_CTXMSG_INC_16

    # as the manual spells it
    INC_1 = INC_ID


class CanCyclicTXStatus(IntEnum):
    """State of an object of the cyclic list."""

    EMPTY = c.CAN_CTXMSG_STAT_EMPTY
    BUSY = c.CAN_CTXMSG_STAT_BUSY
    DONE = c.CAN_CTXMSG_STAT_DONE


class CanCyclicTXTaskStatus(IntEnum):
    """State of the cyclic list; the .NET interface has no such enumeration, the names follow the header."""

    STOPPED = c.CAN_CTXTSK_STAT_STOPPED
    RUNNING = c.CAN_CTXTSK_STAT_RUNNING
