"""The enumerations of Ixxat.Vci4 that are not in V3, or have other values there; the others are V3's.

Source: the vendor's published contract of Ixxat.Vci4 (names and values); cantype.h of VCI 4.1; rulings.md 49.
"""

from __future__ import annotations

from enum import IntEnum, IntFlag

from canwire.vci import controller_types as t
from canwire.vci.structures import constants as c


class VciBusType(IntEnum):
    """The kind of bus of a connector, in V4's order."""

    UNKNOWN = t.VCI_BUS_RES
    CAN = t.VCI_BUS_CAN
    LIN = t.VCI_BUS_LIN
    FLEX_RAY = t.VCI_BUS_FXR

    @classmethod
    def _missing_(cls, value: object) -> VciBusType:
        return cls.UNKNOWN


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
    AUTO_BAUDRATE = c.CAN_FEATURE_AUTOBAUD
    EXTENDED_DATA_LENGTH = c.CAN_FEATURE_EXTDATA
    FAST_DATA_RATE = c.CAN_FEATURE_FASTDATA
    ISO_CAN_FD = c.CAN_FEATURE_ISOFRAME
    NON_ISO_CAN_FD = c.CAN_FEATURE_NONISOFRM
    LONG_BIT_TIME_STAMP = c.CAN_FEATURE_64BITTSC


class CanOperatingModes(IntFlag):
    """The operating mode of a line."""

    UNDEFINED = c.CAN_OPMODE_UNDEFINED
    STANDARD = c.CAN_OPMODE_STANDARD
    EXTENDED = c.CAN_OPMODE_EXTENDED
    MODE_MASK = c.CAN_OPMODE_STANDARD | c.CAN_OPMODE_EXTENDED
    ERR_FRAME = c.CAN_OPMODE_ERRFRAME
    LISTEN_ONLY = c.CAN_OPMODE_LISTONLY
    LOW_SPEED = c.CAN_OPMODE_LOWSPEED
    AUTO_BAUDRATE = c.CAN_OPMODE_AUTOBAUD


class CanExtendedOperatingModes(IntFlag):
    """The extended operating mode of a CAN FD line."""

    UNDEFINED = 0
    EXTENDED_DATA_LENGTH = c.CAN_EXMODE_EXTDATA
    FAST_DATA_RATE = c.CAN_EXMODE_FASTDATA
    NON_ISO_CAN_FD = c.CAN_EXMODE_NONISO


class CanFilterModes(IntFlag):
    """The mode of a filter; PASS_SELF_RECEPTIONS is only for a channel's Initialize."""

    INVALID = c.CAN_FILTER_VOID
    LOCK = c.CAN_FILTER_LOCK
    PASS = c.CAN_FILTER_PASS
    INCLUSIVE = c.CAN_FILTER_INCL
    EXCLUSIVE = c.CAN_FILTER_EXCL
    PASS_SELF_RECEPTIONS = c.CAN_FILTER_SRRA


class CanMsgError(IntEnum):
    """Byte 0 of an ERROR message."""

    STUFF = c.CAN_ERROR_STUFF
    FORM = c.CAN_ERROR_FORM
    ACKNOWLEDGE = c.CAN_ERROR_ACK
    BIT = c.CAN_ERROR_BIT
    FDB = c.CAN_ERROR_FDB
    CRC = c.CAN_ERROR_CRC
    DLC = c.CAN_ERROR_DLC
    OTHER = c.CAN_ERROR_OTHER

    @classmethod
    def _missing_(cls, value: object) -> CanMsgError:
        return cls.OTHER


class CanBitrateMode(IntFlag):
    """The meaning of the numbers in a CanBitrate2: bit/s and ratios, or prescaler and quanta with RAW."""

    NONE = 0
    RAW = c.CAN_BTMODE_RAW
    TRIPLE_SAMPLING = c.CAN_BTMODE_TSM
