/* Structures of VCI itself. Source: VCI V4 manual 7.1; layouts as reference/vci.md section 5 has them. */
#ifndef CANWIRE_VCITYPE_H
#define CANWIRE_VCITYPE_H
#define _VCITYPE_H_
#include <stdtype.h>

#include <pshpack1.h>

typedef union _VCIID {
    LUID AsLuid;
    INT64 AsInt64;
} VCIID, *PVCIID;
CANWIRE_SIZE(VCIID, 8);

#ifdef __cplusplus
typedef const VCIID &REFVCIID;
#else
typedef const VCIID *REFVCIID;
#endif

#define VCI_MAX_BUSCTRL 32

#define VCI_BUS_RES 0
#define VCI_BUS_CAN 1
#define VCI_BUS_LIN 2
#define VCI_BUS_KLN 3
#define VCI_BUS_FXR 4
#define VCI_BUS_CTRL(bus, controller) ((UINT16)((bus) << 8 | (controller)))
#define VCI_BUS_TYPE(word) ((UINT8)((word) >> 8 & 0xFF))
#define VCI_CTL_TYPE(word) ((UINT8)((word)&0xFF))
#define VCI_CAN_UNKNOWN VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_UNKNOWN)
#define VCI_CAN_82527 VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_82527)
#define VCI_CAN_82C200 VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_82C200)
#define VCI_CAN_81C90 VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_81C90)
#define VCI_CAN_81C92 VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_81C92)
#define VCI_CAN_SJA1000 VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_SJA1000)
#define VCI_CAN_82C900 VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_82C900)
#define VCI_CAN_TOUCAN VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_TOUCAN)
#define VCI_CAN_MSCAN VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_MSCAN)
#define VCI_CAN_FLEXCAN VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_FLEXCAN)
#define VCI_CAN_IFICAN VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_IFICAN)
#define VCI_CAN_BCCAN VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_BCCAN)
#define VCI_CAN_BXCAN VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_BXCAN)
#define VCI_CAN_IFICFD VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_IFICFD)
#define VCI_CAN_BMCAN VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_BMCAN)
#define VCI_CAN_IFICFD2 VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_IFICFD2)
#define VCI_CAN_BMCAN2 VCI_BUS_CTRL(VCI_BUS_CAN, CAN_CTRL_BMCAN2)
#define VCI_LIN_UNKNOWN VCI_BUS_CTRL(VCI_BUS_LIN, LIN_CTRL_UNKNOWN)
#define VCI_LIN_GENERIC VCI_BUS_CTRL(VCI_BUS_LIN, LIN_CTRL_GENERIC)
#define VCI_LIN_SERIAL VCI_BUS_CTRL(VCI_BUS_LIN, LIN_CTRL_SERIAL)

typedef struct _VCIVERSIONINFO {
    UINT32 VciMajorVersion;
    UINT32 VciMinorVersion;
    union {
        UINT32 VciRevNumber;
        UINT32 VciReleaseNumber;
    };
    UINT32 VciBuildNumber;
    UINT32 OsMajorVersion;
    UINT32 OsMinorVersion;
    UINT32 OsBuildNumber;
    UINT32 OsPlatformId;
} VCIVERSIONINFO, *PVCIVERSIONINFO;
CANWIRE_SIZE(VCIVERSIONINFO, 32);

typedef struct _VCIDEVICEINFO {
    VCIID VciObjectId;
    GUID DeviceClass;
    UINT8 DriverMajorVersion;
    UINT8 DriverMinorVersion;
    UINT16 DriverBuildVersion;
    UINT8 HardwareBranchVersion;
    UINT8 HardwareMajorVersion;
    UINT8 HardwareMinorVersion;
    UINT8 HardwareBuildVersion;
    union _UniqueHardwareId {
        CHAR AsChar[16];
        GUID AsGuid;
    } UniqueHardwareId;
    CHAR Description[128];
    CHAR Manufacturer[126];
    UINT16 DriverReleaseVersion;
} VCIDEVICEINFO, *PVCIDEVICEINFO;
CANWIRE_SIZE(VCIDEVICEINFO, 304);

typedef struct _VCIDEVICECAPS {
    UINT16 BusCtrlCount;
    UINT16 BusCtrlTypes[VCI_MAX_BUSCTRL];
} VCIDEVICECAPS, *PVCIDEVICECAPS;
CANWIRE_SIZE(VCIDEVICECAPS, 66);

#include <poppack.h>

#endif
