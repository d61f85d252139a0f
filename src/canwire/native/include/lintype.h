/* LIN: constants and structures. Source: VCI V4 manual 7.4; values as reference/vci.md has them. */
#ifndef CANWIRE_LINTYPE_H
#define CANWIRE_LINTYPE_H
#define _LINTYPE_H_
#include <stdtype.h>

#include <pshpack1.h>

#define LIN_CTRL_UNKNOWN 0
#define LIN_CTRL_GENERIC 1
#define LIN_CTRL_SERIAL 2
#define LIN_CTRL_MAXVAL 0xFF

#define LIN_OPMODE_SLAVE 0
#define LIN_OPMODE_MASTER 1
#define LIN_OPMODE_ERRORS 2

#define LIN_FEATURE_MASTER 1
#define LIN_FEATURE_AUTORATE 2
#define LIN_FEATURE_ERRFRAME 4
#define LIN_FEATURE_BUSLOAD 8
#define LIN_FEATURE_SLEEP 0x10
#define LIN_FEATURE_WAKEUP 0x20

#define LIN_BITRATE_UNDEF 65535
#define LIN_BITRATE_AUTO 0
#define LIN_BITRATE_MIN 1000
#define LIN_BITRATE_MAX 20000
#define LIN_BITRATE_1000 1000
#define LIN_BITRATE_1200 1200
#define LIN_BITRATE_2400 2400
#define LIN_BITRATE_4800 4800
#define LIN_BITRATE_9600 9600
#define LIN_BITRATE_10400 10400
#define LIN_BITRATE_19200 19200
#define LIN_BITRATE_20000 20000

#define LIN_STATUS_OVRRUN 1
#define LIN_STATUS_ININIT 0x10
#define LIN_STATUS_TXPEND 2
#define LIN_STATUS_ERRLIM 4
#define LIN_STATUS_BUSOFF 8

#define LIN_MSGTYPE_DATA 0
#define LIN_MSGTYPE_INFO 1
#define LIN_MSGTYPE_ERROR 2
#define LIN_MSGTYPE_STATUS 3
#define LIN_MSGTYPE_WAKEUP 4
#define LIN_MSGTYPE_SLEEP 5
#define LIN_MSGTYPE_TMOVR 6

#define LIN_MSGFLAGS_ECS 1
#define LIN_MSGFLAGS_SOR 2
#define LIN_MSGFLAGS_OVR 4
#define LIN_MSGFLAGS_IDO 8

#define LIN_PIDMASK_ID 0x3F
#define LIN_PIDMASK_PARITY 0xC0

#define LIN_INFO_START 1
#define LIN_INFO_STOP 2
#define LIN_INFO_RESET 3

#define LIN_ERROR_BIT 1
#define LIN_ERROR_CHKSUM 2
#define LIN_ERROR_PARITY 3
#define LIN_ERROR_SLNORE 4
#define LIN_ERROR_SYNC 5
#define LIN_ERROR_NOBUS 6
#define LIN_ERROR_OTHER 7
#define LIN_ERROR_WAKEUP 8

typedef union _LINMSGINFO {
    struct {
        UINT8 bPid;
        UINT8 bType;
        UINT8 bDlen;
        UINT8 bFlags;
    } Bytes;
    struct {
        UINT32 pid : 8;
        UINT32 type : 8;
        UINT32 dlen : 8;
        UINT32 ecs : 1;
        UINT32 sor : 1;
        UINT32 ovr : 1;
        UINT32 ido : 1;
        UINT32 res : 4;
    } Bits;
} LINMSGINFO, *PLINMSGINFO;
CANWIRE_SIZE(LINMSGINFO, 4);

typedef struct _LINCAPABILITIES {
    UINT32 dwFeatures;
    UINT32 dwClockFreq;
    UINT32 dwTscDivisor;
} LINCAPABILITIES, *PLINCAPABILITIES;
CANWIRE_SIZE(LINCAPABILITIES, 12);

typedef struct _LININITLINE {
    UINT8 bOpMode;
    UINT8 bReserved;
    UINT16 wBitrate;
} LININITLINE, *PLININITLINE;
CANWIRE_SIZE(LININITLINE, 4);

typedef struct _LINLINESTATUS {
    UINT8 bOpMode;
    union {
        UINT8 bBusLoad;
        UINT8 bReserved;
    };
    UINT16 wBitrate;
    UINT32 dwStatus;
} LINLINESTATUS, *PLINLINESTATUS;
CANWIRE_SIZE(LINLINESTATUS, 8);

typedef struct _LINMONITORSTATUS {
    LINLINESTATUS sLineStatus;
    BOOL32 fActivated;
    BOOL32 fRxOverrun;
    UINT8 bRxFifoLoad;
} LINMONITORSTATUS, *PLINMONITORSTATUS;
CANWIRE_SIZE(LINMONITORSTATUS, 17);

typedef struct _LINMSG {
    UINT32 dwTime;
    LINMSGINFO uMsgInfo;
    UINT8 abData[8];
} LINMSG, *PLINMSG;
CANWIRE_SIZE(LINMSG, 16);

#include <poppack.h>

#endif
