/* VCI V4: interfaces and functions. Order of methods, IIDs and names as the vendor's headers have them (rulings 49).
 *
 * Source: VCI V4 manual chapter 6; reference/vci.md sections 6 and 7.
 */
#ifndef CANWIRE_VCISDK_H
#define CANWIRE_VCISDK_H
#define _VCISDK_H_
#include <baltype.h>
#include <cantype.h>
#include <lintype.h>
#include <objbase.h>
#include <vcierr.h>
#include <vciguid.h>
#include <vcitype.h>
#include <vciver.h>

#ifndef VCIAPI
#define VCIAPI
#endif
#define VCI_API
#define VCI_APIP

DEFINE_GUID(CLSID_VCIBAL, 0x3CB880F4, 0x2791, 0x40BD, 0xB8, 0x52, 0x09, 0x34, 0x9D, 0x1A, 0x7B, 0x37);
DEFINE_GUID(IID_IVciFifo, 0x25A79E68, 0x912C, 0x41BF, 0x8C, 0xC7, 0xA7, 0x09, 0x67, 0x2F, 0xF1, 0x02);
DEFINE_GUID(IID_IVciFifo2, 0x66E3AA3A, 0x6BF6, 0x47A0, 0xAB, 0x18, 0xEF, 0xC8, 0x01, 0x09, 0x1E, 0x61);
DEFINE_GUID(IID_IFifoReader, 0x19286603, 0xA9CD, 0x433A, 0xA4, 0x95, 0x72, 0xE5, 0xC9, 0xD9, 0x7A, 0x97);
DEFINE_GUID(IID_IFifoWriter, 0xE1CC08CE, 0x99C0, 0x483B, 0x8E, 0x5F, 0x4C, 0x43, 0x35, 0x8E, 0x1C, 0xE2);
DEFINE_GUID(IID_IVciDevice, 0x46DFCF2F, 0x113B, 0x4D01, 0xA8, 0x03, 0xBD, 0x5B, 0x4D, 0x32, 0xC8, 0xF1);
DEFINE_GUID(IID_IVciDevice2, 0xCDC08670, 0xC314, 0x4CA1, 0xBA, 0x6A, 0x51, 0x01, 0x6B, 0xB7, 0xC2, 0x3A);
DEFINE_GUID(IID_IDevStatus, 0xB2485033, 0x9FF6, 0x407C, 0x9C, 0x2F, 0x26, 0x92, 0xFB, 0x68, 0x31, 0x9C);
DEFINE_GUID(IID_IVciEnumDevice, 0x1AD18613, 0xCC67, 0x4AC8, 0x83, 0xFA, 0x6A, 0xD2, 0x4B, 0xDE, 0x62, 0x9A);
DEFINE_GUID(IID_IVciDeviceManager, 0x7724B0A9, 0xE6DB, 0x46B0, 0xA5, 0xD0, 0x46, 0x8C, 0xC4, 0x19, 0x17, 0x32);
DEFINE_GUID(IID_IBalObject, 0xA2B958AA, 0x9188, 0x4CDB, 0x83, 0x07, 0x25, 0xD9, 0xF1, 0xF8, 0x43, 0xE9);
DEFINE_GUID(IID_ICanSocket, 0x48965C25, 0x9F8D, 0x4E4D, 0x8D, 0xE6, 0xF0, 0x29, 0x80, 0x8C, 0x9E, 0xD2);
DEFINE_GUID(IID_ICanSocket2, 0xD914F5A7, 0x12FA, 0x41F6, 0x8A, 0xB4, 0x4E, 0xA8, 0x9F, 0x1C, 0x5F, 0x1E);
DEFINE_GUID(IID_ICanChannel, 0x66FF396B, 0x22EA, 0x42AA, 0xBC, 0x7E, 0x49, 0x19, 0xF8, 0x9F, 0xB4, 0x5C);
DEFINE_GUID(IID_ICanChannel2, 0xF2528F90, 0x3A10, 0x46D0, 0x8F, 0x82, 0x08, 0x71, 0xC1, 0xE7, 0xDB, 0xB9);
DEFINE_GUID(IID_ICanControl, 0xD213C143, 0x7039, 0x4D1D, 0xAC, 0xED, 0x13, 0x90, 0x28, 0x9C, 0x8E, 0xBA);
DEFINE_GUID(IID_ICanControl2, 0xEFD3A8E2, 0x09E3, 0x4115, 0x86, 0x9F, 0x93, 0xE5, 0x79, 0x16, 0x74, 0x31);
DEFINE_GUID(IID_ICanScheduler, 0xC936498F, 0xEC52, 0x4C74, 0xB3, 0xFE, 0xA4, 0x72, 0xBA, 0x73, 0x65, 0xBA);
DEFINE_GUID(IID_ICanScheduler2, 0x70E3E8B8, 0x852F, 0x48E0, 0xBD, 0xDB, 0xB1, 0x0A, 0x0C, 0x44, 0xCB, 0x3F);
DEFINE_GUID(IID_ICanStatus, 0x10795437, 0x1028, 0x4A32, 0x91, 0x0D, 0x0E, 0x19, 0x23, 0x62, 0x24, 0xDA);
DEFINE_GUID(IID_ICanStatus2, 0xF686F1A4, 0x4AC5, 0x438B, 0xA6, 0x76, 0x18, 0xCF, 0x6B, 0x9B, 0xA4, 0x22);
DEFINE_GUID(IID_ICanObject, 0xB346CF15, 0x5CD5, 0x4E08, 0x9E, 0xF1, 0x3A, 0xEA, 0x3F, 0x34, 0xAE, 0x0C);
DEFINE_GUID(IID_ICanObject2, 0x264853AB, 0x7D0C, 0x4690, 0x92, 0x4D, 0x97, 0xF0, 0x6B, 0x5B, 0xD3, 0x1C);
DEFINE_GUID(IID_ILinSocket, 0xEF865638, 0x6D07, 0x4A46, 0xA8, 0x38, 0x4B, 0xAF, 0xED, 0x35, 0x9B, 0x1A);
DEFINE_GUID(IID_ILinMonitor, 0x29068E57, 0x6B69, 0x4010, 0x91, 0x1C, 0x7A, 0x91, 0x28, 0x52, 0x1B, 0xE0);
DEFINE_GUID(IID_ILinControl, 0x4D58EF55, 0x4F01, 0x451E, 0x91, 0x1F, 0x17, 0xC2, 0x23, 0xA8, 0xB8, 0xF0);
#ifndef _WIN32
CANWIRE_GUID(IID_IUnknown);
#endif

/* A FIFO seen from outside. */
#undef INTERFACE
#define INTERFACE IVciFifo
DECLARE_INTERFACE_(IVciFifo, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(GetCapacity)(THIS_ PUINT16 pwCapacity) PURE;
    STDMETHOD(GetEntrySize)(THIS_ PUINT16 pwSize) PURE;
    STDMETHOD(GetFreeCount)(THIS_ PUINT16 pwCount) PURE;
    STDMETHOD(GetFillCount)(THIS_ PUINT16 pwCount) PURE;
    STDMETHOD(GetFillLevel)(THIS_ PUINT16 pwLevel) PURE;
};
#undef INTERFACE
typedef IVciFifo *PVCIFIFO;

/* The same, which can empty it. */
#undef INTERFACE
#define INTERFACE IVciFifo2
DECLARE_INTERFACE_(IVciFifo2, IVciFifo)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(GetCapacity)(THIS_ PUINT16 pwCapacity) PURE;
    STDMETHOD(GetEntrySize)(THIS_ PUINT16 pwSize) PURE;
    STDMETHOD(GetFreeCount)(THIS_ PUINT16 pwCount) PURE;
    STDMETHOD(GetFillCount)(THIS_ PUINT16 pwCount) PURE;
    STDMETHOD(GetFillLevel)(THIS_ PUINT16 pwLevel) PURE;
    STDMETHOD(Reset)(THIS) PURE;
};
#undef INTERFACE
typedef IVciFifo2 *PVCIFIFO2;

/* The end of a FIFO that elements are read from. */
#undef INTERFACE
#define INTERFACE IFifoReader
DECLARE_INTERFACE_(IFifoReader, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(Lock)(THIS) PURE;
    STDMETHOD(Unlock)(THIS) PURE;
    STDMETHOD(AssignEvent)(THIS_ HANDLE hEvent) PURE;
    STDMETHOD(SetThreshold)(THIS_ UINT16 wThreshold) PURE;
    STDMETHOD(GetThreshold)(THIS_ PUINT16 pwThreshold) PURE;
    STDMETHOD(GetCapacity)(THIS_ PUINT16 pwCapacity) PURE;
    STDMETHOD(GetEntrySize)(THIS_ PUINT16 pwSize) PURE;
    STDMETHOD(GetFillCount)(THIS_ PUINT16 pwCount) PURE;
    STDMETHOD(GetFreeCount)(THIS_ PUINT16 pwCount) PURE;
    STDMETHOD(GetDataEntry)(THIS_ PVOID pvData) PURE;
    STDMETHOD(AcquireRead)(THIS_ PVOID *ppvData, PUINT16 pwCount) PURE;
    STDMETHOD(ReleaseRead)(THIS_ UINT16 wCount) PURE;
};
#undef INTERFACE
typedef IFifoReader *PFIFOREADER;

/* The end of a FIFO that elements are written to. */
#undef INTERFACE
#define INTERFACE IFifoWriter
DECLARE_INTERFACE_(IFifoWriter, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(Lock)(THIS) PURE;
    STDMETHOD(Unlock)(THIS) PURE;
    STDMETHOD(AssignEvent)(THIS_ HANDLE hEvent) PURE;
    STDMETHOD(SetThreshold)(THIS_ UINT16 wThreshold) PURE;
    STDMETHOD(GetThreshold)(THIS_ PUINT16 pwThreshold) PURE;
    STDMETHOD(GetCapacity)(THIS_ PUINT16 pwCapacity) PURE;
    STDMETHOD(GetEntrySize)(THIS_ PUINT16 pwSize) PURE;
    STDMETHOD(GetFillCount)(THIS_ PUINT16 pwCount) PURE;
    STDMETHOD(GetFreeCount)(THIS_ PUINT16 pwCount) PURE;
    STDMETHOD(PutDataEntry)(THIS_ PVOID pvData) PURE;
    STDMETHOD(AcquireWrite)(THIS_ PVOID *ppvData, PUINT16 pwCount) PURE;
    STDMETHOD(ReleaseWrite)(THIS_ UINT16 wCount) PURE;
};
#undef INTERFACE
typedef IFifoWriter *PFIFOWRITER;

/* One board. */
#undef INTERFACE
#define INTERFACE IVciDevice
DECLARE_INTERFACE_(IVciDevice, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(GetDeviceInfo)(THIS_ PVCIDEVICEINFO pInfo) PURE;
    STDMETHOD(GetDeviceCaps)(THIS_ PVCIDEVICECAPS pCaps) PURE;
    STDMETHOD(OpenComponent)(THIS_ REFCLSID rcid, REFIID riid, PVOID *ppv) PURE;
};
#undef INTERFACE
typedef IVciDevice *PVCIDEVICE;

/* A look through the list of boards. */
#undef INTERFACE
#define INTERFACE IVciEnumDevice
DECLARE_INTERFACE_(IVciEnumDevice, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(Next)(THIS_ UINT32 dwNumElem, PVCIDEVICEINFO paDevInfo, PUINT32 pdwFetched) PURE;
    STDMETHOD(Skip)(THIS_ UINT32 dwNumElem) PURE;
    STDMETHOD(Reset)(THIS) PURE;
    STDMETHOD(AssignEvent)(THIS_ HANDLE hEvent) PURE;
};
#undef INTERFACE
typedef IVciEnumDevice *PVCIENUMDEVICE;

/* The list of boards. */
#undef INTERFACE
#define INTERFACE IVciDeviceManager
DECLARE_INTERFACE_(IVciDeviceManager, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(EnumDevices)(THIS_ PVCIENUMDEVICE *ppEnum) PURE;
    STDMETHOD(OpenDevice)(THIS_ REFVCIID rVciidDev, PVCIDEVICE *ppDevice) PURE;
};
#undef INTERFACE
typedef IVciDeviceManager *PVCIDEVICEMANAGER;

/* The bus access layer of a board. */
#undef INTERFACE
#define INTERFACE IBalObject
DECLARE_INTERFACE_(IBalObject, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(GetFeatures)(THIS_ PBALFEATURES pFeatures) PURE;
    STDMETHOD(OpenSocket)(THIS_ UINT32 dwBusNo, REFIID riid, PVOID *ppv) PURE;
};
#undef INTERFACE
typedef IBalObject *PBALOBJECT;

/* What sets a CAN line up. */
#undef INTERFACE
#define INTERFACE ICanControl
DECLARE_INTERFACE_(ICanControl, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(DetectBaud)(THIS_ UINT16 wTimeoutMs, PCANBTRTABLE pBtrTable) PURE;
    STDMETHOD(InitLine)(THIS_ PCANINITLINE pInit) PURE;
    STDMETHOD(ResetLine)(THIS) PURE;
    STDMETHOD(StartLine)(THIS) PURE;
    STDMETHOD(StopLine)(THIS) PURE;
    STDMETHOD(GetLineStatus)(THIS_ PCANLINESTATUS pStatus) PURE;
    STDMETHOD(SetAccFilter)(THIS_ UINT8 bSelect, UINT32 dwCode, UINT32 dwMask) PURE;
    STDMETHOD(AddFilterIds)(THIS_ UINT8 bSelect, UINT32 dwCode, UINT32 dwMask) PURE;
    STDMETHOD(RemFilterIds)(THIS_ UINT8 bSelect, UINT32 dwCode, UINT32 dwMask) PURE;
};
#undef INTERFACE
typedef ICanControl *PCANCONTROL;

/* What sets a CAN FD line up. */
#undef INTERFACE
#define INTERFACE ICanControl2
DECLARE_INTERFACE_(ICanControl2, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(DetectBaud)(THIS_ UINT8 bOpMode, UINT8 bExMode, UINT16 wTimeoutMs, PCANBTPTABLE pBtpTable) PURE;
    STDMETHOD(InitLine)(THIS_ PCANINITLINE2 pInit) PURE;
    STDMETHOD(ResetLine)(THIS) PURE;
    STDMETHOD(StartLine)(THIS) PURE;
    STDMETHOD(StopLine)(THIS) PURE;
    STDMETHOD(GetLineStatus)(THIS_ PCANLINESTATUS2 pStatus) PURE;
    STDMETHOD(GetFilterMode)(THIS_ UINT8 bSelect, PUINT8 pbMode) PURE;
    STDMETHOD(SetFilterMode)(THIS_ UINT8 bSelect, UINT8 bMode, PUINT8 pbPrev) PURE;
    STDMETHOD(SetAccFilter)(THIS_ UINT8 bSelect, UINT32 dwCode, UINT32 dwMask) PURE;
    STDMETHOD(AddFilterIds)(THIS_ UINT8 bSelect, UINT32 dwCode, UINT32 dwMask) PURE;
    STDMETHOD(RemFilterIds)(THIS_ UINT8 bSelect, UINT32 dwCode, UINT32 dwMask) PURE;
};
#undef INTERFACE
typedef ICanControl2 *PCANCONTROL2;

/* A program's queues of CANMSG. */
#undef INTERFACE
#define INTERFACE ICanChannel
DECLARE_INTERFACE_(ICanChannel, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(Initialize)(THIS_ UINT16 wRxFifoSize, UINT16 wTxFifoSize) PURE;
    STDMETHOD(Activate)(THIS) PURE;
    STDMETHOD(Deactivate)(THIS) PURE;
    STDMETHOD(GetReader)(THIS_ PFIFOREADER *ppReader) PURE;
    STDMETHOD(GetWriter)(THIS_ PFIFOWRITER *ppWriter) PURE;
    STDMETHOD(GetStatus)(THIS_ PCANCHANSTATUS pStatus) PURE;
};
#undef INTERFACE
typedef ICanChannel *PCANCHANNEL;

/* A program's queues of CANMSG2. */
#undef INTERFACE
#define INTERFACE ICanChannel2
DECLARE_INTERFACE_(ICanChannel2, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(Initialize)(THIS_ UINT32 dwRxFifoSize, UINT32 dwTxFifoSize, UINT32 dwFilterSize,
        UINT8 bFilterMode) PURE;
    STDMETHOD(Activate)(THIS) PURE;
    STDMETHOD(Deactivate)(THIS) PURE;
    STDMETHOD(GetReader)(THIS_ PFIFOREADER *ppReader) PURE;
    STDMETHOD(GetWriter)(THIS_ PFIFOWRITER *ppWriter) PURE;
    STDMETHOD(GetStatus)(THIS_ PCANCHANSTATUS2 pStatus) PURE;
    STDMETHOD(GetControl)(THIS_ PCANCONTROL2 *ppCanCtrl) PURE;
    STDMETHOD(GetFilterMode)(THIS_ UINT8 bSelect, PUINT8 pbMode) PURE;
    STDMETHOD(SetFilterMode)(THIS_ UINT8 bSelect, UINT8 bMode, PUINT8 pbPrev) PURE;
    STDMETHOD(SetAccFilter)(THIS_ UINT8 bSelect, UINT32 dwCode, UINT32 dwMask) PURE;
    STDMETHOD(AddFilterIds)(THIS_ UINT8 bSelect, UINT32 dwCode, UINT32 dwMask) PURE;
    STDMETHOD(RemFilterIds)(THIS_ UINT8 bSelect, UINT32 dwCode, UINT32 dwMask) PURE;
};
#undef INTERFACE
typedef ICanChannel2 *PCANCHANNEL2;

/* Messages that a line sends again and again. */
#undef INTERFACE
#define INTERFACE ICanScheduler
DECLARE_INTERFACE_(ICanScheduler, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(Resume)(THIS) PURE;
    STDMETHOD(Suspend)(THIS) PURE;
    STDMETHOD(Reset)(THIS) PURE;
    STDMETHOD(GetStatus)(THIS_ PCANSCHEDULERSTATUS pStatus) PURE;
    STDMETHOD(AddMessage)(THIS_ PCANCYCLICTXMSG pMessage, PUINT32 pdwIndex) PURE;
    STDMETHOD(RemMessage)(THIS_ UINT32 dwIndex) PURE;
    STDMETHOD(StartMessage)(THIS_ UINT32 dwIndex, UINT32 dwCount) PURE;
    STDMETHOD(StopMessage)(THIS_ UINT32 dwIndex) PURE;
};
#undef INTERFACE
typedef ICanScheduler *PCANSCHEDULER;

/* The same for CAN FD. */
#undef INTERFACE
#define INTERFACE ICanScheduler2
DECLARE_INTERFACE_(ICanScheduler2, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(Resume)(THIS) PURE;
    STDMETHOD(Suspend)(THIS) PURE;
    STDMETHOD(Reset)(THIS) PURE;
    STDMETHOD(GetStatus)(THIS_ PCANSCHEDULERSTATUS2 pStatus) PURE;
    STDMETHOD(AddMessage)(THIS_ PCANCYCLICTXMSG2 pMessage, PUINT32 pdwIndex) PURE;
    STDMETHOD(RemMessage)(THIS_ UINT32 dwIndex) PURE;
    STDMETHOD(StartMessage)(THIS_ UINT32 dwIndex, UINT32 dwCount) PURE;
    STDMETHOD(StopMessage)(THIS_ UINT32 dwIndex) PURE;
};
#undef INTERFACE
typedef ICanScheduler2 *PCANSCHEDULER2;

/* What a CAN line can do and how it is. */
#undef INTERFACE
#define INTERFACE ICanSocket
DECLARE_INTERFACE_(ICanSocket, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(GetSocketInfo)(THIS_ PBALSOCKETINFO pInfo) PURE;
    STDMETHOD(GetCapabilities)(THIS_ PCANCAPABILITIES pCaps) PURE;
    STDMETHOD(GetLineStatus)(THIS_ PCANLINESTATUS pStatus) PURE;
    STDMETHOD(CreateChannel)(THIS_ BOOL fExclusive, PCANCHANNEL *ppChannel) PURE;
};
#undef INTERFACE
typedef ICanSocket *PCANSOCKET;

/* The same for CAN FD. */
#undef INTERFACE
#define INTERFACE ICanSocket2
DECLARE_INTERFACE_(ICanSocket2, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(GetSocketInfo)(THIS_ PBALSOCKETINFO pInfo) PURE;
    STDMETHOD(GetCapabilities)(THIS_ PCANCAPABILITIES2 pCaps) PURE;
    STDMETHOD(GetLineStatus)(THIS_ PCANLINESTATUS2 pStatus) PURE;
    STDMETHOD(CreateChannel)(THIS_ BOOL fExclusive, PCANCHANNEL2 *ppChannel) PURE;
};
#undef INTERFACE
typedef ICanSocket2 *PCANSOCKET2;

/* What a LIN line hears. */
#undef INTERFACE
#define INTERFACE ILinMonitor
DECLARE_INTERFACE_(ILinMonitor, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(Initialize)(THIS_ UINT16 wRxFifoSize) PURE;
    STDMETHOD(Activate)(THIS) PURE;
    STDMETHOD(Deactivate)(THIS) PURE;
    STDMETHOD(GetReader)(THIS_ PFIFOREADER *ppReader) PURE;
    STDMETHOD(GetStatus)(THIS_ PLINMONITORSTATUS pStatus) PURE;
};
#undef INTERFACE
typedef ILinMonitor *PLINMONITOR;

/* What sets a LIN line up and sends on it. */
#undef INTERFACE
#define INTERFACE ILinControl
DECLARE_INTERFACE_(ILinControl, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(InitLine)(THIS_ PLININITLINE pInit) PURE;
    STDMETHOD(ResetLine)(THIS) PURE;
    STDMETHOD(StartLine)(THIS) PURE;
    STDMETHOD(StopLine)(THIS) PURE;
    STDMETHOD(WriteMessage)(THIS_ BOOL fSend, PLINMSG pLinMsg) PURE;
    STDMETHOD(GetLineStatus)(THIS_ PLINLINESTATUS pStatus) PURE;
};
#undef INTERFACE
typedef ILinControl *PLINCONTROL;

/* What a LIN line can do and how it is. */
#undef INTERFACE
#define INTERFACE ILinSocket
DECLARE_INTERFACE_(ILinSocket, IUnknown)
{
    STDMETHOD(QueryInterface)(THIS_ REFIID riid, PVOID *ppv) PURE;
    STDMETHOD_(ULONG, AddRef)(THIS) PURE;
    STDMETHOD_(ULONG, Release)(THIS) PURE;
    STDMETHOD(GetSocketInfo)(THIS_ PBALSOCKETINFO pInfo) PURE;
    STDMETHOD(GetCapabilities)(THIS_ PLINCAPABILITIES pCaps) PURE;
    STDMETHOD(GetLineStatus)(THIS_ PLINLINESTATUS pStatus) PURE;
    STDMETHOD(CreateMonitor)(THIS_ BOOL fExclusive, PLINMONITOR *ppMonitor) PURE;
};
#undef INTERFACE
typedef ILinSocket *PLINSOCKET;

#pragma GCC visibility push(default)
EXTERN_C HRESULT VCIAPI VciInitialize(void);
EXTERN_C HRESULT VCIAPI VciGetVersion(PVCIVERSIONINFO pVersInfo);
EXTERN_C HRESULT VCIAPI VciFormatErrorA(HRESULT hrError, PCHAR pszError, UINT32 dwLength);
EXTERN_C HRESULT VCIAPI VciFormatErrorW(HRESULT hrError, PWCHAR pszError, UINT32 dwLength);
EXTERN_C HRESULT VCIAPI VciCreateLuid(PVCIID pVciid);
EXTERN_C HRESULT VCIAPI VciLuidToCharA(REFVCIID rVciid, PCHAR pszLuid, UINT32 dwLength);
EXTERN_C HRESULT VCIAPI VciLuidToCharW(REFVCIID rVciid, PWCHAR pszLuid, UINT32 dwLength);
EXTERN_C HRESULT VCIAPI VciCharToLuidA(PCHAR pszLuid, PVCIID pVciid);
EXTERN_C HRESULT VCIAPI VciCharToLuidW(PWCHAR pszLuid, PVCIID pVciid);
EXTERN_C HRESULT VCIAPI VciGuidToCharA(REFGUID rGuid, PCHAR pszGuid, UINT32 dwLength);
EXTERN_C HRESULT VCIAPI VciGuidToCharW(REFGUID rGuid, PWCHAR pszGuid, UINT32 dwLength);
EXTERN_C HRESULT VCIAPI VciCharToGuidA(PCHAR pszGuid, PGUID pGuid);
EXTERN_C HRESULT VCIAPI VciCharToGuidW(PWCHAR pszGuid, PGUID pGuid);
EXTERN_C UINT64 VCIAPI VciQueryTickCounter(void);
EXTERN_C UINT32 VCIAPI VciQueryTickFrequency(void);
EXTERN_C UINT64 VCIAPI VciQueryCurrentTime(void);
EXTERN_C HRESULT VCIAPI VciCreateFifo(PVCIID pResid, UINT16 wCapacity, UINT16 wElemSize, REFIID riid, PVOID *ppv);
EXTERN_C HRESULT VCIAPI VciAccessFifo(REFVCIID rResid, REFIID riid, PVOID *ppv);
EXTERN_C HRESULT VCIAPI VciGetDeviceManager(IVciDeviceManager **ppDevMan);
EXTERN_C HRESULT VCIAPI VciQueryDeviceByHwid(REFGUID rHwid, IVciDevice **ppDevice);
EXTERN_C HRESULT VCIAPI VciQueryDeviceByClass(REFGUID rClass, UINT32 dwInst, IVciDevice **ppDevice);
#pragma GCC visibility pop

#ifdef UNICODE
#define VciFormatError VciFormatErrorW
#define VciLuidToChar VciLuidToCharW
#define VciCharToLuid VciCharToLuidW
#define VciGuidToChar VciGuidToCharW
#define VciCharToGuid VciCharToGuidW
#else
#define VciFormatError VciFormatErrorA
#define VciLuidToChar VciLuidToCharA
#define VciCharToLuid VciCharToLuidA
#define VciGuidToChar VciGuidToCharA
#define VciCharToGuid VciCharToGuidA
#endif
#endif
