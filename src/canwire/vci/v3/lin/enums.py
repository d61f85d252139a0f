"""The enumerations of V3's LIN part, in Python's spelling; flags can be combined with OR.

The .NET interface has no names for LIN_STATUS_TXPEND, _ERRLIM and _BUSOFF, nor for LIN_ERROR_WAKEUP.
Source: VCI V3 .NET manual 4.3; reference/vci.md sections 4, 7a and 9.
"""

from __future__ import annotations

from enum import IntEnum, IntFlag

from canwire.vci.lin import constants as c


class LinOperatingModes(IntFlag):
    """The operating mode of a line."""

    SLAVE = c.LIN_OPMODE_SLAVE
    MASTER = c.LIN_OPMODE_MASTER
    ERRORS = c.LIN_OPMODE_ERRORS


class LinFeatures(IntFlag):
    """The capabilities of a controller."""

    MASTER = c.LIN_FEATURE_MASTER
    AUTORATE = c.LIN_FEATURE_AUTORATE
    ERR_FRAME = c.LIN_FEATURE_ERRFRAME
    BUSLOAD = c.LIN_FEATURE_BUSLOAD
    SLEEP = c.LIN_FEATURE_SLEEP
    WAKEUP = c.LIN_FEATURE_WAKEUP


class LinCtrlStatus(IntFlag):
    """State of a controller; bits without a name are kept."""

    OVERRUN = c.LIN_STATUS_OVRRUN
    IN_INIT = c.LIN_STATUS_ININIT


class LinMessageType(IntEnum):
    """The kind of a message; a master sends DATA, SLEEP and WAKEUP, a slave only WAKEUP."""

    DATA = c.LIN_MSGTYPE_DATA
    INFO = c.LIN_MSGTYPE_INFO
    ERROR = c.LIN_MSGTYPE_ERROR
    STATUS = c.LIN_MSGTYPE_STATUS
    WAKEUP = c.LIN_MSGTYPE_WAKEUP
    SLEEP = c.LIN_MSGTYPE_SLEEP
    TIME_OVERRUN = c.LIN_MSGTYPE_TMOVR


class LinMsgInfoValue(IntEnum):
    """Byte 0 of an INFO message: the new state of the controller."""

    START = c.LIN_INFO_START
    STOP = c.LIN_INFO_STOP
    RESET = c.LIN_INFO_RESET


class LinMsgError(IntEnum):
    """Byte 0 of an ERROR message; an error that is not in V3 is OTHER."""

    BIT = c.LIN_ERROR_BIT
    CRC = c.LIN_ERROR_CHKSUM
    PARITY = c.LIN_ERROR_PARITY
    SLAVE_NO_RESPONSE = c.LIN_ERROR_SLNORE
    SYNC = c.LIN_ERROR_SYNC
    NO_BUS = c.LIN_ERROR_NOBUS
    OTHER = c.LIN_ERROR_OTHER

    @classmethod
    def _missing_(cls, value: object) -> LinMsgError:
        return cls.OTHER
