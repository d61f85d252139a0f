"""The LIN constants of lintype.h, with their names; flags can be combined with OR.

Source: lintype.h of VCI 4.1; VCI V4 manual 7.4; reference/vci.md sections 2 and 4.
"""

from __future__ import annotations

from canwire.vci.controller_types import VCI_BUS_LIN, vci_bus_ctrl

# controller types, bits 7-0 of the word that controller_types.py describes
LIN_CTRL_UNKNOWN = 0
LIN_CTRL_GENERIC = 1
LIN_CTRL_SERIAL = 2
LIN_CTRL_MAXVAL = 0xFF

VCI_LIN_UNKNOWN = vci_bus_ctrl(VCI_BUS_LIN, LIN_CTRL_UNKNOWN)
VCI_LIN_GENERIC = vci_bus_ctrl(VCI_BUS_LIN, LIN_CTRL_GENERIC)
VCI_LIN_SERIAL = vci_bus_ctrl(VCI_BUS_LIN, LIN_CTRL_SERIAL)

# operating mode: LININITLINE.bOpMode
LIN_OPMODE_SLAVE = 0x00  # always on
LIN_OPMODE_MASTER = 0x01
LIN_OPMODE_ERRORS = 0x02  # report errors as messages

# what a controller can do: LINCAPABILITIES.dwFeatures
LIN_FEATURE_MASTER = 0x01
LIN_FEATURE_AUTORATE = 0x02  # a slave detects the bit rate
LIN_FEATURE_ERRFRAME = 0x04
LIN_FEATURE_BUSLOAD = 0x08
LIN_FEATURE_SLEEP = 0x10  # a master sends go-to-sleep
LIN_FEATURE_WAKEUP = 0x20

# bit rate in bit/s: LININITLINE.wBitrate
LIN_BITRATE_UNDEF = 65535
LIN_BITRATE_AUTO = 0
LIN_BITRATE_MIN = 1000
LIN_BITRATE_MAX = 20000
LIN_BITRATE_1000 = 1000
LIN_BITRATE_1200 = 1200
LIN_BITRATE_2400 = 2400
LIN_BITRATE_4800 = 4800
LIN_BITRATE_9600 = 9600
LIN_BITRATE_10400 = 10400
LIN_BITRATE_19200 = 19200
LIN_BITRATE_20000 = 20000

# state of the controller: LINLINESTATUS.dwStatus
LIN_STATUS_OVRRUN = 0x01  # the controller lost received frames
LIN_STATUS_ININIT = 0x10  # stopped
# The manual also has these three, lintype.h does not. A public port of lintype.h has two of them at these bits, and
# TXPEND at the bit that is OVRRUN in lintype.h; here TXPEND has the free bit.
LIN_STATUS_TXPEND = 0x02  # a frame is being sent
LIN_STATUS_ERRLIM = 0x04  # the error counter overflowed
LIN_STATUS_BUSOFF = 0x08

# message type: LINMSGINFO.Bits.type
LIN_MSGTYPE_DATA = 0
LIN_MSGTYPE_INFO = 1
LIN_MSGTYPE_ERROR = 2
LIN_MSGTYPE_STATUS = 3
LIN_MSGTYPE_WAKEUP = 4
LIN_MSGTYPE_SLEEP = 5
LIN_MSGTYPE_TMOVR = 6  # the time stamp counter wrapped around

# bits of LINMSGINFO.Bytes.bFlags
LIN_MSGFLAGS_ECS = 0x01  # enhanced checksum
LIN_MSGFLAGS_SOR = 0x02  # sender of response
LIN_MSGFLAGS_OVR = 0x04
LIN_MSGFLAGS_IDO = 0x08  # id only

# parts of the protected identifier: LINMSGINFO.Bits.pid
LIN_PIDMASK_ID = 0x3F
LIN_PIDMASK_PARITY = 0xC0

# abData[0] of LIN_MSGTYPE_INFO
LIN_INFO_START = 1
LIN_INFO_STOP = 2
LIN_INFO_RESET = 3

# abData[0] of LIN_MSGTYPE_ERROR
LIN_ERROR_BIT = 1
LIN_ERROR_CHKSUM = 2
LIN_ERROR_PARITY = 3  # of the identifier
LIN_ERROR_SLNORE = 4  # no slave responds
LIN_ERROR_SYNC = 5
LIN_ERROR_NOBUS = 6  # no bus activity
LIN_ERROR_OTHER = 7
LIN_ERROR_WAKEUP = 8  # not in the manual
