/* Structures of the bus access layer. Source: VCI V4 manual 7.2. */
#ifndef CANWIRE_BALTYPE_H
#define CANWIRE_BALTYPE_H
#define _BALTYPE_H_
#include <vcitype.h>

#include <pshpack1.h>

#define BAL_MAX_SOCKETS VCI_MAX_BUSCTRL

typedef struct _BALFEATURES {
    UINT16 FwMajorVersion;
    UINT16 FwMinorVersion;
    UINT16 BusSocketCount;
    UINT16 BusSocketType[BAL_MAX_SOCKETS];
} BALFEATURES, *PBALFEATURES;
CANWIRE_SIZE(BALFEATURES, 70);

typedef struct _BALSOCKETINFO {
    union {
        VCIID ObjectId;
        VCIID Obid;
    };
    union {
        UINT16 BusType;
        UINT16 Type;
    };
    union {
        UINT16 SocketNo;
        UINT16 BusNo;
    };
} BALSOCKETINFO, *PBALSOCKETINFO;
CANWIRE_SIZE(BALSOCKETINFO, 12);

#include <poppack.h>

#endif
