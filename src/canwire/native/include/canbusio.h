/* CANDRV's structures, events, commands and control codes, for programs in C (libcandrv).
 *
 * CAN_DWORD has 32 bits, as `unsigned long` has on Windows CE. Programs that bring a canbusio.h of their own take this
 * one in its place: on Linux `unsigned long` has the size of a pointer.
 * Source: CANDRV manual V2.06, appendix A.
 */
#ifndef __CANBUSIO_H__
#define __CANBUSIO_H__

#include <windows.h>
#include <tchar.h>
#include <fileapi.h>
#include <winioctl.h>
#include <winuser.h>

#define CAN_DWORD unsigned int
#define CAN_BYTE unsigned char
#define CAN_UINT unsigned int
#define CAN_INT int

#define MAX_DEVICE_NAME_LENGTH 100
#define CANBUS_NUMBER_OF_CONSTANT_BAUDRATES 50

/* modes */
#define CANBUS_FORMAT_CAN_2_0_A 0
#define CANBUS_FORMAT_CAN_2_0_B 1

/* CAN_PROPERTIES.chipset_flags */
#define CANBUS_CFS_CAN_2_0_A (1 << 0)
#define CANBUS_CFS_CAN_2_0_B (1 << 1)
#define CANBUS_CFS_EXT_FRAME (1 << 2)
#define CANBUS_CFS_POLLING (1 << 3)

/* CAN_TRANSMIT_DATA.fmt */
#define CANBUS_TRANS_FMT_DEFAULT 0
#define CANBUS_TRANS_FMT_STD 1
#define CANBUS_TRANS_FMT_EXT 2

enum t_canbus_events {
    CANBUS_EVENT_RECEIVED = 0x001,
    CANBUS_EVENT_TRANSMITTED = 0x002,
    CANBUS_EVENT_BUS_ERROR = 0x004,
    CANBUS_EVENT_WARNING = 0x008,
    CANBUS_EVENT_LEAVING_STANDBY = 0x010,
    CANBUS_EVENT_ARBITRATION_LOST = 0x020,
    CANBUS_EVENT_OVERRUN = 0x040,
    CANBUS_EVENT_PASSIVE = 0x080,
    CANBUS_EVENT_ENTERING_STANDBY = 0x100,
    CANBUS_EVENT_DEVICE_CHANGED = 0x200,
    CANBUS_EVENT_ABORTED = 0x400
};

enum t_canbus_commands {
    CANBUS_CMD_ENTER_STANDBY = 1,
    CANBUS_CMD_ABORT_TRANSMISSION,
    CANBUS_CMD_CLEAR_OVERRUN,
    CANBUS_CMD_LEAVE_STANDBY,
    CANBUS_CMD_SELF_RECEPTION_REQUEST,
    CANBUS_CMD_LISTEN_ON,
    CANBUS_CMD_LISTEN_OFF,
    CANBUS_CMD_VIRTUALIZE_ON,
    CANBUS_CMD_VIRTUALIZE_OFF,
    CANBUS_CMD_LAST_ENTRY
};

typedef struct tagCAN_TIME { /* `low` in milliseconds; it wraps without touching `high` */
    CAN_DWORD low;
    CAN_DWORD high;
} CAN_TIME, *PCAN_TIME;

typedef struct tagCAN_ACCEPTANCE_FILTER {
    CAN_DWORD code;
    CAN_DWORD mask;
} CAN_ACCEPTANCE_FILTER, *PCAN_ACCEPTANCE_FILTER;

typedef struct tagCAN_PROPERTIES {
    CAN_DWORD version; /* major << 8 | minor */
    TCHAR device_name[MAX_DEVICE_NAME_LENGTH];
    CAN_DWORD min; /* rates in bit/s */
    CAN_DWORD max;
    CAN_INT nCommands;
    CAN_INT commands[CANBUS_CMD_LAST_ENTRY];
    CAN_INT nBaudrates;
    CAN_DWORD baudrates[CANBUS_NUMBER_OF_CONSTANT_BAUDRATES];
    CAN_DWORD chipset_flags;
    CAN_INT nRegisters;
} CAN_PROPERTIES, *PCAN_PROPERTIES;

typedef struct tagCAN_TRANSMIT_DATA {
    CAN_UINT fmt;
    CAN_DWORD identifier; /* aligned as the registry's Align says */
    CAN_BYTE rtr;
    CAN_BYTE dlc;
    CAN_BYTE msg[8];
} CAN_TRANSMIT_DATA, *PCAN_TRANSMIT_DATA;

typedef struct tagCAN_EVENT {
    CAN_DWORD event;
    CAN_TIME time;
    CAN_DWORD lost; /* events since the one before */
    CAN_TRANSMIT_DATA data; /* of messages received, transmitted or aborted; `fmt` says nothing */
    CAN_UINT arbitration;
} CAN_EVENT, *PCAN_EVENT;

#define CAN_DEV 0x00008007
#define CAN_BUFF METHOD_BUFFERED
#define CAN_READ FILE_READ_ACCESS
#define CAN_WRITE FILE_WRITE_ACCESS
#define CAN_ANY FILE_ANY_ACCESS

#define IOCTL_CAN_WRITE_ACCEPTANCE_FILTER CTL_CODE(CAN_DEV, 0x801, CAN_BUFF, CAN_WRITE)
#define IOCTL_CAN_READ_ACCEPTANCE_FILTER CTL_CODE(CAN_DEV, 0x802, CAN_BUFF, CAN_READ)
#define IOCTL_CAN_SET_BAUDRATE CTL_CODE(CAN_DEV, 0x803, CAN_BUFF, CAN_ANY)
#define IOCTL_CAN_GET_BAUDRATE CTL_CODE(CAN_DEV, 0x804, CAN_BUFF, CAN_ANY)
#define IOCTL_CAN_INIT CTL_CODE(CAN_DEV, 0x805, CAN_BUFF, CAN_ANY)
#define IOCTL_CAN_SET_BAUDRATE_BY_CONSTANT CTL_CODE(CAN_DEV, 0x806, CAN_BUFF, CAN_ANY)
#define IOCTL_CAN_GET_BAUDRATE_BY_CONSTANT CTL_CODE(CAN_DEV, 0x807, CAN_BUFF, CAN_ANY)
#define IOCTL_CAN_SET_CAN_MODE CTL_CODE(CAN_DEV, 0x808, CAN_BUFF, CAN_ANY)
#define IOCTL_CAN_SET_COMMAND CTL_CODE(CAN_DEV, 0x809, CAN_BUFF, CAN_ANY)
#define IOCTL_CAN_WRITE_TRANSMIT_DATA CTL_CODE(CAN_DEV, 0x80A, CAN_BUFF, CAN_WRITE)
#define IOCTL_CAN_READ_EVENT_DATA CTL_CODE(CAN_DEV, 0x80B, CAN_BUFF, CAN_ANY)
#define IOCTL_CAN_READ_TIME CTL_CODE(CAN_DEV, 0x80C, CAN_BUFF, CAN_READ)
#define IOCTL_CAN_SET_DEFAULT_FRAME_FORMAT CTL_CODE(CAN_DEV, 0x80D, CAN_BUFF, CAN_ANY)
#define IOCTL_CAN_TEST_DEVICE CTL_CODE(CAN_DEV, 0x80E, CAN_BUFF, CAN_ANY)
#define IOCTL_CAN_READ_PROPERTIES CTL_CODE(CAN_DEV, 0x80F, CAN_BUFF, CAN_ANY)
#define IOCTL_CAN_READ_REGISTER CTL_CODE(CAN_DEV, 0x810, CAN_BUFF, CAN_ANY)
#define IOCTL_CAN_WRITE_REGISTER CTL_CODE(CAN_DEV, 0x811, CAN_BUFF, CAN_ANY)
#define IOCTL_CAN_READ_REGISTER_RM CTL_CODE(CAN_DEV, 0x812, CAN_BUFF, CAN_ANY)
#define IOCTL_CAN_WRITE_REGISTER_RM CTL_CODE(CAN_DEV, 0x813, CAN_BUFF, CAN_ANY)

#endif
