// vcinpl: the flat interface for CANMSG.
#include "canwire.h"

#include <vcinpl.h>

struct Api {
    using Socket = ICanSocket;
    using Control = ICanControl;
    using Channel = ICanChannel;
    using Scheduler = ICanScheduler;
    using Message = CANMSG;
    using CyclicMessage = CANCYCLICTXMSG;
    using Capabilities = CANCAPABILITIES;
    using LineStatus = CANLINESTATUS;
    using ChannelStatus = CANCHANSTATUS;
    using SchedulerStatus = CANSCHEDULERSTATUS;

    static REFIID socket()
    {
        return IID_ICanSocket;
    }

    static REFIID control()
    {
        return IID_ICanControl;
    }

    static REFIID scheduler()
    {
        return IID_ICanScheduler;
    }

    // Errors that VCI V3 had no code for are others.
    static HRESULT told(HRESULT result, Message *messages, UINT32 count, PUINT32 done)
    {
        static const UINT8 FAST_DATA_BIT = 5, DLC = 7;

        for (Message *at = messages; at < messages + count; at++)
            if (at->uMsgInfo.Bytes.bType == CAN_MSGTYPE_ERROR && (at->abData[0] == FAST_DATA_BIT || at->abData[0] >= DLC))
                at->abData[0] = CAN_ERROR_OTHER;
        if (done != nullptr)
            *done = count;
        return result;
    }
};

#include "../flat/can_calls.h"

HRESULT vciGetVersion(PUINT32 major, PUINT32 minor)
{
    UINT32 revision, build;

    return vciGetVersionEx(major, minor, &revision, &build);
}

HRESULT vciGetVersionEx(PUINT32 major, PUINT32 minor, PUINT32 revision, PUINT32 build)
{
    VCIVERSIONINFO info;
    HRESULT result = VciGetVersion(&info);

    if (major == nullptr || minor == nullptr || revision == nullptr || build == nullptr)
        return VCI_E_INVALIDARG;
    if (result == VCI_OK) {
        *major = info.VciMajorVersion;
        *minor = info.VciMinorVersion;
        *revision = info.VciRevNumber;
        *build = info.VciBuildNumber;
    }
    return result;
}

HRESULT canControlDetectBitrate(HANDLE handle, UINT16 timeout_ms, UINT32 count, PUINT8 bt0, PUINT8 bt1, PINT32 index)
{
    Use<Control> opened(handle);
    CANBTRTABLE table = {};
    HRESULT result;

    if (!opened)
        return VCI_E_INVHANDLE;
    if (bt0 == nullptr || bt1 == nullptr || index == nullptr || count > sizeof table.abBtr0)
        return VCI_E_INVALIDARG;
    table.bCount = static_cast<UINT8>(count);
    memcpy(table.abBtr0, bt0, count);
    memcpy(table.abBtr1, bt1, count);
    result = opened->control->DetectBaud(timeout_ms, &table);
    *index = result == VCI_OK ? table.bIndex : -1;
    return result;
}

HRESULT canControlInitialize(HANDLE handle, UINT8 mode, UINT8 bt0, UINT8 bt1)
{
    Use<Control> opened(handle);
    CANINITLINE init = {mode, 0, bt0, bt1};

    return opened ? opened->control->InitLine(&init) : VCI_E_INVHANDLE;
}

HRESULT canChannelInitialize(HANDLE handle, UINT16 receive, UINT16 receive_threshold, UINT16 transmit,
                             UINT16 transmit_threshold)
{
    Use<Channel> opened(handle);
    HRESULT result;

    if (!opened)
        return VCI_E_INVHANDLE;
    opened->received.close();
    opened->to_send.close();
    result = opened->channel->Initialize(receive, transmit);
    return result == VCI_OK ? opened->open_queues(receive_threshold, transmit, transmit_threshold) : result;
}

HRESULT canChannelPeekMultipleMessages(HANDLE handle, PUINT32 count, CANMSG into[])
{
    return count != nullptr ? canChannelPeekMsgMult(handle, into, *count, count) : VCI_E_INVALIDARG;
}

HRESULT canChannelPostMultipleMessages(HANDLE handle, PUINT32 count, CANMSG messages[])
{
    return count != nullptr ? canChannelPostMsgMult(handle, messages, *count, count) : VCI_E_INVALIDARG;
}

HRESULT canChannelReadMultipleMessages(HANDLE handle, UINT32 timeout_ms, PUINT32 count, CANMSG into[])
{
    return count != nullptr ? canChannelReadMsgMult(handle, timeout_ms, into, *count, count) : VCI_E_INVALIDARG;
}

HRESULT canChannelSendMultipleMessages(HANDLE handle, UINT32 timeout_ms, PUINT32 count, CANMSG messages[])
{
    return count != nullptr ? canChannelSendMsgMult(handle, timeout_ms, messages, *count, count) : VCI_E_INVALIDARG;
}
