"""The enumerations of Ixxat.Vci4 that V3 lacks, or has with other values; the rest are V3's.

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
    """What a controller can do."""

    STD_OR_EXT = c.CAN_FEATURE_STDOREXT  # 11 or 29 bits, not both at once
    STD_AND_EXT = c.CAN_FEATURE_STDANDEXT  # both at once
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
    """How a line is set up."""

    UNDEFINED = c.CAN_OPMODE_UNDEFINED
    STANDARD = c.CAN_OPMODE_STANDARD
    EXTENDED = c.CAN_OPMODE_EXTENDED
    MODE_MASK = c.CAN_OPMODE_STANDARD | c.CAN_OPMODE_EXTENDED
    ERR_FRAME = c.CAN_OPMODE_ERRFRAME
    LISTEN_ONLY = c.CAN_OPMODE_LISTONLY
    LOW_SPEED = c.CAN_OPMODE_LOWSPEED
    AUTO_BAUDRATE = c.CAN_OPMODE_AUTOBAUD


class CanExtendedOperatingModes(IntFlag):
    """How a CAN FD line is set up."""

    UNDEFINED = 0
    EXTENDED_DATA_LENGTH = c.CAN_EXMODE_EXTDATA
    FAST_DATA_RATE = c.CAN_EXMODE_FASTDATA
    NON_ISO_CAN_FD = c.CAN_EXMODE_NONISO


class CanFilterModes(IntFlag):
    """What a filter does; PASS_SELF_RECEPTIONS is for a channel's Initialize."""

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
    """What the figures of a CanBitrate2 are: bit/s and ratios, or with RAW prescaler and quanta."""

    NONE = 0
    RAW = c.CAN_BTMODE_RAW
    TRIPLE_SAMPLING = c.CAN_BTMODE_TSM
