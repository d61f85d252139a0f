"""The constants of ACAN.H: enumerations, and their members under the manual's names.

Source: INduCAN104 manual, "Data structures", "Programming interface" and annex A.
"""

from __future__ import annotations

from enum import IntEnum, IntFlag


class Format(IntFlag):
    """ACANMB.bFormat: the kind of frame."""

    EXTENDED = 0x80  # 29-bit identifier
    RTR = 0x40  # remote frame


class Action(IntFlag):
    """ACANID.bAction: what the driver does with a message that passes a filter.

    CHANRCV or CHANSND makes the filter a channel; a filter cannot have both.
    """

    NOTIFY = 0x80
    QUEUE = 0x40  # into the Task Block's FIFO
    CHANRCV = 0x20  # the message's data into a variable
    CHANSND = 0x10  # a variable's value out in a message
    QUEUEMSG = QUEUE


class Notification(IntEnum):
    """ACANTB.bNotType: how the driver notifies an application."""

    EVENT = 0
    CALLBACK = 1
    POSTMESSAGE = 2


class BlockStatus(IntFlag):
    """Low byte of ACANTB.wStatus: what the application has not acknowledged yet."""

    SC = 0x01  # a special condition occurred: see the high byte
    MB = 0x02  # messages have been buffered
    OVERFLOW = 0x04  # messages have been discarded because the FIFO was full


class Condition(IntFlag):
    """ACANTB.bSCFilter, and high byte of ACANTB.wStatus: special conditions of the bus."""

    BUSERR = 0x80
    ARBLOST = 0x40
    ERRPAS = 0x20  # error passive state reached
    WAKEUP = 0x10  # never happens
    OVERRUN = 0x08  # the controller's buffers were full
    NOBUFF = 0x04  # the driver's buffers were full
    ERRLIM = 0x02  # an error counter reached 96
    BUSOFF = 0x01


class BusState(IntEnum):
    """BUS_STATE of ACAN_BusControl: whether the controller takes part in the bus."""

    OFF = 0
    ON = 1


class Interrupt(IntFlag):
    """ACANHI.hi_ien: the controller's Interrupt Enable Register."""

    BEIE = 0x80  # bus error
    ALIE = 0x40  # arbitration lost
    EPIE = 0x20  # error passive, error active
    WUIE = 0x10  # wake-up
    DOIE = 0x08  # data overrun
    EIE = 0x04  # error warning, bus off
    TIE = 0x02  # ready to transmit
    RIE = 0x01  # a message received


class Service(IntEnum):
    """AL at the driver's entry point (annex A). 9 means the same as 0, since Windows 95 cannot call a VxD with 0."""

    GET_VERSION = 0
    HARD_CONFIGURE = 1
    HARD_STATUS = 2
    HARD_CONTROL = 3
    REGISTER = 4
    ACK = 5
    FREE = 6
    SEND = 7
    RECEIVE = 8
    GET_VERSION_1 = 9


FF_EXTENDED = Format.EXTENDED
FF_RTR = Format.RTR

IDA_NOTIFY = Action.NOTIFY
IDA_QUEUEMSG = Action.QUEUE
IDA_CHANRCV = Action.CHANRCV
IDA_CHANSND = Action.CHANSND

TBNT_EVENT = Notification.EVENT
TBNT_CALLBACK = Notification.CALLBACK
TBNT_POSTMESSAGE = Notification.POSTMESSAGE

TBS_SC = BlockStatus.SC
TBS_MB = BlockStatus.MB
TBS_OVERFLOW = BlockStatus.OVERFLOW

SC_BUSERR = Condition.BUSERR
SC_ARBLOST = Condition.ARBLOST
SC_ERRPAS = Condition.ERRPAS
SC_WAKEUP = Condition.WAKEUP
SC_OVERRUN = Condition.OVERRUN
SC_NOBUFF = Condition.NOBUFF
SC_ERRLIM = Condition.ERRLIM
SC_BUSOFF = Condition.BUSOFF

BUS_STATE = BusState
BUS_OFF = BusState.OFF
BUS_ON = BusState.ON

CANC_SJA1000 = 0  # controller type: low byte of ACAN_GetInitStatus

DEFAULT_OUTPUT_CONTROL = 0x6A  # recommended OCR: normal mode, pull-down drivers at TX0 and TX1
DEFAULT_INTERRUPTS = Interrupt.BEIE | Interrupt.EPIE | Interrupt.DOIE | Interrupt.EIE | Interrupt.RIE  # 0xAD

ACAN_GET_VERSION = Service.GET_VERSION
ACAN_HARD_CONFIGURE = Service.HARD_CONFIGURE
ACAN_HARD_STATUS = Service.HARD_STATUS
ACAN_HARD_CONTROL = Service.HARD_CONTROL
ACAN_REGISTER = Service.REGISTER
ACAN_ACK = Service.ACK
ACAN_FREE = Service.FREE
ACAN_SEND = Service.SEND
ACAN_RECEIVE = Service.RECEIVE
ACAN_GET_VERSION_1 = Service.GET_VERSION_1
