/* The flat interface of VCI. Names and parameters as the vendor's vcinpl.h has them (rulings 49). */
#ifndef CANWIRE_VCINPL_H
#define CANWIRE_VCINPL_H
#define _VCINPL_H_
#include <vcisdk.h>

/* Here errors have the codes of VCI V3, whatever was told. */
#undef CAN_ERROR_OTHER
#define CAN_ERROR_OTHER 7
#undef CAN_ERROR_FDB
#undef CAN_ERROR_DLC

#pragma GCC visibility push(default)

/* The library itself. */
EXTERN_C HRESULT VCIAPI vciInitialize(void);
EXTERN_C HRESULT VCIAPI vciGetVersion(PUINT32 pdwMajorVersion, PUINT32 pdwMinorVersion);
EXTERN_C HRESULT VCIAPI vciGetVersionEx(PUINT32 pdwMajorVersion, PUINT32 pdwMinorVersion, PUINT32 pdwRevNumber,
    PUINT32 pdwBuildNumber);
EXTERN_C void VCIAPI vciFormatErrorA(HRESULT hrError, PCHAR pszText, UINT32 dwLength);
EXTERN_C void VCIAPI vciFormatErrorW(HRESULT hrError, PWCHAR pszText, UINT32 dwLength);
EXTERN_C void VCIAPI vciDisplayErrorA(HWND hwndParent, PCHAR pszCaption, HRESULT hrError);
EXTERN_C void VCIAPI vciDisplayErrorW(HWND hwndParent, PWCHAR pszCaption, HRESULT hrError);
EXTERN_C HRESULT VCIAPI vciCreateLuid(PVCIID pVciid);
EXTERN_C HRESULT VCIAPI vciLuidToCharA(REFVCIID rVciid, PCHAR pszLuid, LONG cbSize);
EXTERN_C HRESULT VCIAPI vciLuidToCharW(REFVCIID rVciid, PWCHAR pszLuid, LONG cbSize);
EXTERN_C HRESULT VCIAPI vciCharToLuidA(PCHAR pszLuid, PVCIID pVciid);
EXTERN_C HRESULT VCIAPI vciCharToLuidW(PWCHAR pszLuid, PVCIID pVciid);
EXTERN_C HRESULT VCIAPI vciGuidToCharA(REFGUID rGuid, PCHAR pszGuid, LONG cbSize);
EXTERN_C HRESULT VCIAPI vciGuidToCharW(REFGUID rGuid, PWCHAR pszGuid, LONG cbSize);
EXTERN_C HRESULT VCIAPI vciCharToGuidA(PCHAR pszGuid, PGUID pGuid);
EXTERN_C HRESULT VCIAPI vciCharToGuidW(PWCHAR pszGuid, PGUID pGuid);

/* Events. */
EXTERN_C HRESULT VCIAPI vciEventCreate(BOOL fManReset, BOOL fInitState, PHANDLE phEvent);
EXTERN_C HRESULT VCIAPI vciEventDelete(HANDLE hEvent);
EXTERN_C HRESULT VCIAPI vciEventSignal(HANDLE hEvent);
EXTERN_C HRESULT VCIAPI vciEventReset(HANDLE hEvent);
EXTERN_C HRESULT VCIAPI vciEventWaitFor(HANDLE hEvent, UINT32 dwTimeout);

/* The list of devices; vciSelectDeviceDlg takes the first one: there is no dialog. */
EXTERN_C HRESULT VCIAPI vciEnumDeviceOpen(PHANDLE hEnum);
EXTERN_C HRESULT VCIAPI vciEnumDeviceClose(HANDLE hEnum);
EXTERN_C HRESULT VCIAPI vciEnumDeviceNext(HANDLE hEnum, PVCIDEVICEINFO pInfo);
EXTERN_C HRESULT VCIAPI vciEnumDeviceReset(HANDLE hEnum);
EXTERN_C HRESULT VCIAPI vciEnumDeviceWaitEvent(HANDLE hEnum, UINT32 dwTimeout);
EXTERN_C HRESULT VCIAPI vciFindDeviceByHwid(REFGUID rHwid, PVCIID pVciid);
EXTERN_C HRESULT VCIAPI vciFindDeviceByClass(REFGUID rClass, UINT32 dwInst, PVCIID pVciid);
EXTERN_C HRESULT VCIAPI vciSelectDeviceDlg(HWND hwndParent, PVCIID pVciid);

/* A device; vciDeviceOpenDlg opens the first one. */
EXTERN_C HRESULT VCIAPI vciDeviceOpen(REFVCIID rVciid, PHANDLE phDevice);
EXTERN_C HRESULT VCIAPI vciDeviceOpenDlg(HWND hwndParent, PHANDLE phDevice);
EXTERN_C HRESULT VCIAPI vciDeviceClose(HANDLE hDevice);
EXTERN_C HRESULT VCIAPI vciDeviceGetInfo(HANDLE hDevice, PVCIDEVICEINFO pInfo);
EXTERN_C HRESULT VCIAPI vciDeviceGetCaps(HANDLE hDevice, PVCIDEVICECAPS pCaps);

/* What sets a CAN line up. */
EXTERN_C HRESULT VCIAPI canControlOpen(HANDLE hDevice, UINT32 dwCanNo, PHANDLE phCanCtl);
EXTERN_C HRESULT VCIAPI canControlClose(HANDLE hCanCtl);
EXTERN_C HRESULT VCIAPI canControlGetCaps(HANDLE hCanCtl, PCANCAPABILITIES pCanCaps);
EXTERN_C HRESULT VCIAPI canControlGetStatus(HANDLE hCanCtl, PCANLINESTATUS pStatus);
EXTERN_C HRESULT VCIAPI canControlDetectBitrate(HANDLE hCanCtl, UINT16 wMsTimeout, UINT32 dwCount,
    PUINT8 pabBtr0, PUINT8 pabBtr1, PINT32 plIndex);
EXTERN_C HRESULT VCIAPI canControlInitialize(HANDLE hCanCtl, UINT8 bMode, UINT8 bBtr0, UINT8 bBtr1);
EXTERN_C HRESULT VCIAPI canControlReset(HANDLE hCanCtl);
EXTERN_C HRESULT VCIAPI canControlStart(HANDLE hCanCtl, BOOL fStart);
EXTERN_C HRESULT VCIAPI canControlSetAccFilter(HANDLE hCanCtl, BOOL fExtend, UINT32 dwCode, UINT32 dwMask);
EXTERN_C HRESULT VCIAPI canControlAddFilterIds(HANDLE hCanCtl, BOOL fExtend, UINT32 dwCode, UINT32 dwMask);
EXTERN_C HRESULT VCIAPI canControlRemFilterIds(HANDLE hCanCtl, BOOL fExtend, UINT32 dwCode, UINT32 dwMask);

/* A program's queues on a CAN line; Post and Peek do not wait. */
EXTERN_C HRESULT VCIAPI canChannelOpen(HANDLE hDevice, UINT32 dwCanNo, BOOL fExclusive, PHANDLE phCanChn);
EXTERN_C HRESULT VCIAPI canChannelClose(HANDLE hCanChn);
EXTERN_C HRESULT VCIAPI canChannelGetCaps(HANDLE hCanChn, PCANCAPABILITIES pCanCaps);
EXTERN_C HRESULT VCIAPI canChannelGetStatus(HANDLE hCanChn, PCANCHANSTATUS pStatus);
EXTERN_C HRESULT VCIAPI canChannelInitialize(HANDLE hCanChn, UINT16 wRxFifoSize, UINT16 wRxThreshold,
    UINT16 wTxFifoSize, UINT16 wTxThreshold);
EXTERN_C HRESULT VCIAPI canChannelActivate(HANDLE hCanChn, BOOL fEnable);
EXTERN_C HRESULT VCIAPI canChannelPeekMessage(HANDLE hCanChn, PCANMSG pCanMsg);
EXTERN_C HRESULT VCIAPI canChannelPeekMsgMult(HANDLE hCanChn, CANMSG aCanMsg[], UINT32 dwCount, PUINT32 pdwDone);
EXTERN_C HRESULT VCIAPI canChannelPostMessage(HANDLE hCanChn, PCANMSG pCanMsg);
EXTERN_C HRESULT VCIAPI canChannelPostMsgMult(HANDLE hCanChn, CANMSG aCanMsg[], UINT32 dwCount, PUINT32 pdwDone);
EXTERN_C HRESULT VCIAPI canChannelWaitRxEvent(HANDLE hCanChn, UINT32 dwTimeout);
EXTERN_C HRESULT VCIAPI canChannelWaitTxEvent(HANDLE hCanChn, UINT32 dwTimeout);
EXTERN_C HRESULT VCIAPI canChannelReadMessage(HANDLE hCanChn, UINT32 dwTimeout, PCANMSG pCanMsg);
EXTERN_C HRESULT VCIAPI canChannelReadMsgMult(HANDLE hCanChn, UINT32 dwTimeout, CANMSG aCanMsg[],
    UINT32 dwCount, PUINT32 pdwDone);
EXTERN_C HRESULT VCIAPI canChannelSendMessage(HANDLE hCanChn, UINT32 dwTimeout, PCANMSG pCanMsg);
EXTERN_C HRESULT VCIAPI canChannelSendMsgMult(HANDLE hCanChn, UINT32 dwTimeout, CANMSG aCanMsg[],
    UINT32 dwCount, PUINT32 pdwDone);
EXTERN_C HRESULT VCIAPI canChannelPeekMultipleMessages(HANDLE hCanChn, PUINT32 pdwCount, CANMSG aCanMsg[]);
EXTERN_C HRESULT VCIAPI canChannelPostMultipleMessages(HANDLE hCanChn, PUINT32 pdwCount, CANMSG aCanMsg[]);
EXTERN_C HRESULT VCIAPI canChannelReadMultipleMessages(HANDLE hCanChn, UINT32 dwTimeout, PUINT32 pdwCount,
    CANMSG aCanMsg[]);
EXTERN_C HRESULT VCIAPI canChannelSendMultipleMessages(HANDLE hCanChn, UINT32 dwTimeout, PUINT32 pdwCount,
    CANMSG aCanMsg[]);

/* Messages that a line sends again and again. */
EXTERN_C HRESULT VCIAPI canSchedulerOpen(HANDLE hDevice, UINT32 dwCanNo, PHANDLE phCanShd);
EXTERN_C HRESULT VCIAPI canSchedulerClose(HANDLE hCanShd);
EXTERN_C HRESULT VCIAPI canSchedulerGetCaps(HANDLE hCanShd, PCANCAPABILITIES pCanCaps);
EXTERN_C HRESULT VCIAPI canSchedulerGetStatus(HANDLE hCanShd, PCANSCHEDULERSTATUS pStatus);
EXTERN_C HRESULT VCIAPI canSchedulerActivate(HANDLE hCanShd, BOOL fEnable);
EXTERN_C HRESULT VCIAPI canSchedulerReset(HANDLE hCanShd);
EXTERN_C HRESULT VCIAPI canSchedulerAddMessage(HANDLE hCanShd, PCANCYCLICTXMSG pMessage, PUINT32 pdwIndex);
EXTERN_C HRESULT VCIAPI canSchedulerRemMessage(HANDLE hCanShd, UINT32 dwIndex);
EXTERN_C HRESULT VCIAPI canSchedulerStartMessage(HANDLE hCanShd, UINT32 dwIndex, UINT16 wRepeat);
EXTERN_C HRESULT VCIAPI canSchedulerStopMessage(HANDLE hCanShd, UINT32 dwIndex);

/* What sets a LIN line up. */
EXTERN_C HRESULT VCIAPI linControlOpen(HANDLE hDevice, UINT32 dwLinNo, PHANDLE phLinCtl);
EXTERN_C HRESULT VCIAPI linControlClose(HANDLE hLinCtl);
EXTERN_C HRESULT VCIAPI linControlGetCaps(HANDLE hLinCtl, PLINCAPABILITIES pLinCaps);
EXTERN_C HRESULT VCIAPI linControlGetStatus(HANDLE hLinCtl, PLINLINESTATUS pStatus);
EXTERN_C HRESULT VCIAPI linControlInitialize(HANDLE hLinCtl, UINT8 bMode, UINT16 wBitrate);
EXTERN_C HRESULT VCIAPI linControlReset(HANDLE hLinCtl);
EXTERN_C HRESULT VCIAPI linControlStart(HANDLE hLinCtl, BOOL fStart);
EXTERN_C HRESULT VCIAPI linControlWriteMessage(HANDLE hLinCtl, BOOL fSend, PLINMSG pLinMsg);

/* What a LIN line hears. */
EXTERN_C HRESULT VCIAPI linMonitorOpen(HANDLE hDevice, UINT32 dwLinNo, BOOL fExclusive, PHANDLE phLinMon);
EXTERN_C HRESULT VCIAPI linMonitorClose(HANDLE hLinMon);
EXTERN_C HRESULT VCIAPI linMonitorGetCaps(HANDLE hLinMon, PLINCAPABILITIES pLinCaps);
EXTERN_C HRESULT VCIAPI linMonitorGetStatus(HANDLE hLinMon, PLINMONITORSTATUS pStatus);
EXTERN_C HRESULT VCIAPI linMonitorInitialize(HANDLE hLinMon, UINT16 wFifoSize, UINT16 wThreshold);
EXTERN_C HRESULT VCIAPI linMonitorActivate(HANDLE hLinMon, BOOL fEnable);
EXTERN_C HRESULT VCIAPI linMonitorPeekMessage(HANDLE hLinMon, PLINMSG pLinMsg);
EXTERN_C HRESULT VCIAPI linMonitorPeekMsgMult(HANDLE hLinMon, LINMSG aLinMsg[], UINT32 dwCount, PUINT32 pdwDone);
EXTERN_C HRESULT VCIAPI linMonitorWaitRxEvent(HANDLE hLinMon, UINT32 dwTimeout);
EXTERN_C HRESULT VCIAPI linMonitorReadMessage(HANDLE hLinMon, UINT32 dwTimeout, PLINMSG pLinMsg);
EXTERN_C HRESULT VCIAPI linMonitorReadMsgMult(HANDLE hLinMon, UINT32 dwTimeout, LINMSG aLinMsg[],
    UINT32 dwCount, PUINT32 pdwDone);

#pragma GCC visibility pop

/* Their types, for programs that find them by name. */
typedef __typeof__(vciInitialize) *PF_vciInitialize;
typedef __typeof__(vciGetVersion) *PF_vciGetVersion;
typedef __typeof__(vciGetVersionEx) *PF_vciGetVersionEx;
typedef __typeof__(vciFormatErrorA) *PF_vciFormatErrorA;
typedef __typeof__(vciFormatErrorW) *PF_vciFormatErrorW;
typedef __typeof__(vciDisplayErrorA) *PF_vciDisplayErrorA;
typedef __typeof__(vciDisplayErrorW) *PF_vciDisplayErrorW;
typedef __typeof__(vciCreateLuid) *PF_vciCreateLuid;
typedef __typeof__(vciLuidToCharA) *PF_vciLuidToCharA;
typedef __typeof__(vciLuidToCharW) *PF_vciLuidToCharW;
typedef __typeof__(vciCharToLuidA) *PF_vciCharToLuidA;
typedef __typeof__(vciCharToLuidW) *PF_vciCharToLuidW;
typedef __typeof__(vciGuidToCharA) *PF_vciGuidToCharA;
typedef __typeof__(vciGuidToCharW) *PF_vciGuidToCharW;
typedef __typeof__(vciCharToGuidA) *PF_vciCharToGuidA;
typedef __typeof__(vciCharToGuidW) *PF_vciCharToGuidW;
typedef __typeof__(vciEventCreate) *PF_vciEventCreate;
typedef __typeof__(vciEventDelete) *PF_vciEventDelete;
typedef __typeof__(vciEventSignal) *PF_vciEventSignal;
typedef __typeof__(vciEventReset) *PF_vciEventReset;
typedef __typeof__(vciEventWaitFor) *PF_vciEventWaitFor;
typedef __typeof__(vciEnumDeviceOpen) *PF_vciEnumDeviceOpen;
typedef __typeof__(vciEnumDeviceClose) *PF_vciEnumDeviceClose;
typedef __typeof__(vciEnumDeviceNext) *PF_vciEnumDeviceNext;
typedef __typeof__(vciEnumDeviceReset) *PF_vciEnumDeviceReset;
typedef __typeof__(vciEnumDeviceWaitEvent) *PF_vciEnumDeviceWaitEvent;
typedef __typeof__(vciFindDeviceByHwid) *PF_vciFindDeviceByHwid;
typedef __typeof__(vciFindDeviceByClass) *PF_vciFindDeviceByClass;
typedef __typeof__(vciSelectDeviceDlg) *PF_vciSelectDeviceDlg;
typedef __typeof__(vciDeviceOpen) *PF_vciDeviceOpen;
typedef __typeof__(vciDeviceOpenDlg) *PF_vciDeviceOpenDlg;
typedef __typeof__(vciDeviceClose) *PF_vciDeviceClose;
typedef __typeof__(vciDeviceGetInfo) *PF_vciDeviceGetInfo;
typedef __typeof__(vciDeviceGetCaps) *PF_vciDeviceGetCaps;
typedef __typeof__(canControlOpen) *PF_canControlOpen;
typedef __typeof__(canControlClose) *PF_canControlClose;
typedef __typeof__(canControlGetCaps) *PF_canControlGetCaps;
typedef __typeof__(canControlGetStatus) *PF_canControlGetStatus;
typedef __typeof__(canControlDetectBitrate) *PF_canControlDetectBitrate;
typedef __typeof__(canControlInitialize) *PF_canControlInitialize;
typedef __typeof__(canControlReset) *PF_canControlReset;
typedef __typeof__(canControlStart) *PF_canControlStart;
typedef __typeof__(canControlSetAccFilter) *PF_canControlSetAccFilter;
typedef __typeof__(canControlAddFilterIds) *PF_canControlAddFilterIds;
typedef __typeof__(canControlRemFilterIds) *PF_canControlRemFilterIds;
typedef __typeof__(canChannelOpen) *PF_canChannelOpen;
typedef __typeof__(canChannelClose) *PF_canChannelClose;
typedef __typeof__(canChannelGetCaps) *PF_canChannelGetCaps;
typedef __typeof__(canChannelGetStatus) *PF_canChannelGetStatus;
typedef __typeof__(canChannelInitialize) *PF_canChannelInitialize;
typedef __typeof__(canChannelActivate) *PF_canChannelActivate;
typedef __typeof__(canChannelPeekMessage) *PF_canChannelPeekMessage;
typedef __typeof__(canChannelPeekMsgMult) *PF_canChannelPeekMsgMult;
typedef __typeof__(canChannelPostMessage) *PF_canChannelPostMessage;
typedef __typeof__(canChannelPostMsgMult) *PF_canChannelPostMsgMult;
typedef __typeof__(canChannelWaitRxEvent) *PF_canChannelWaitRxEvent;
typedef __typeof__(canChannelWaitTxEvent) *PF_canChannelWaitTxEvent;
typedef __typeof__(canChannelReadMessage) *PF_canChannelReadMessage;
typedef __typeof__(canChannelReadMsgMult) *PF_canChannelReadMsgMult;
typedef __typeof__(canChannelSendMessage) *PF_canChannelSendMessage;
typedef __typeof__(canChannelSendMsgMult) *PF_canChannelSendMsgMult;
typedef __typeof__(canChannelPeekMultipleMessages) *PF_canChannelPeekMultipleMessages;
typedef __typeof__(canChannelPostMultipleMessages) *PF_canChannelPostMultipleMessages;
typedef __typeof__(canChannelReadMultipleMessages) *PF_canChannelReadMultipleMessages;
typedef __typeof__(canChannelSendMultipleMessages) *PF_canChannelSendMultipleMessages;
typedef __typeof__(canSchedulerOpen) *PF_canSchedulerOpen;
typedef __typeof__(canSchedulerClose) *PF_canSchedulerClose;
typedef __typeof__(canSchedulerGetCaps) *PF_canSchedulerGetCaps;
typedef __typeof__(canSchedulerGetStatus) *PF_canSchedulerGetStatus;
typedef __typeof__(canSchedulerActivate) *PF_canSchedulerActivate;
typedef __typeof__(canSchedulerReset) *PF_canSchedulerReset;
typedef __typeof__(canSchedulerAddMessage) *PF_canSchedulerAddMessage;
typedef __typeof__(canSchedulerRemMessage) *PF_canSchedulerRemMessage;
typedef __typeof__(canSchedulerStartMessage) *PF_canSchedulerStartMessage;
typedef __typeof__(canSchedulerStopMessage) *PF_canSchedulerStopMessage;
typedef __typeof__(linControlOpen) *PF_linControlOpen;
typedef __typeof__(linControlClose) *PF_linControlClose;
typedef __typeof__(linControlGetCaps) *PF_linControlGetCaps;
typedef __typeof__(linControlGetStatus) *PF_linControlGetStatus;
typedef __typeof__(linControlInitialize) *PF_linControlInitialize;
typedef __typeof__(linControlReset) *PF_linControlReset;
typedef __typeof__(linControlStart) *PF_linControlStart;
typedef __typeof__(linControlWriteMessage) *PF_linControlWriteMessage;
typedef __typeof__(linMonitorOpen) *PF_linMonitorOpen;
typedef __typeof__(linMonitorClose) *PF_linMonitorClose;
typedef __typeof__(linMonitorGetCaps) *PF_linMonitorGetCaps;
typedef __typeof__(linMonitorGetStatus) *PF_linMonitorGetStatus;
typedef __typeof__(linMonitorInitialize) *PF_linMonitorInitialize;
typedef __typeof__(linMonitorActivate) *PF_linMonitorActivate;
typedef __typeof__(linMonitorPeekMessage) *PF_linMonitorPeekMessage;
typedef __typeof__(linMonitorPeekMsgMult) *PF_linMonitorPeekMsgMult;
typedef __typeof__(linMonitorWaitRxEvent) *PF_linMonitorWaitRxEvent;
typedef __typeof__(linMonitorReadMessage) *PF_linMonitorReadMessage;
typedef __typeof__(linMonitorReadMsgMult) *PF_linMonitorReadMsgMult;

#ifdef UNICODE
#define vciFormatError vciFormatErrorW
#define PF_vciFormatError PF_vciFormatErrorW
#define vciDisplayError vciDisplayErrorW
#define PF_vciDisplayError PF_vciDisplayErrorW
#define vciLuidToChar vciLuidToCharW
#define PF_vciLuidToChar PF_vciLuidToCharW
#define vciCharToLuid vciCharToLuidW
#define PF_vciCharToLuid PF_vciCharToLuidW
#define vciGuidToChar vciGuidToCharW
#define PF_vciGuidToChar PF_vciGuidToCharW
#define vciCharToGuid vciCharToGuidW
#define PF_vciCharToGuid PF_vciCharToGuidW
#else
#define vciFormatError vciFormatErrorA
#define PF_vciFormatError PF_vciFormatErrorA
#define vciDisplayError vciDisplayErrorA
#define PF_vciDisplayError PF_vciDisplayErrorA
#define vciLuidToChar vciLuidToCharA
#define PF_vciLuidToChar PF_vciLuidToCharA
#define vciCharToLuid vciCharToLuidA
#define PF_vciCharToLuid PF_vciCharToLuidA
#define vciGuidToChar vciGuidToCharA
#define PF_vciGuidToChar PF_vciGuidToCharA
#define vciCharToGuid vciCharToGuidA
#define PF_vciCharToGuid PF_vciCharToGuidA
#endif
#endif
