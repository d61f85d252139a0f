// vcinpl2: the flat interface for CANMSG2, with CAN FD.
#include "canwire.h"

#include <vcinpl2.h>

struct Api {
    using Socket = ICanSocket2;
    using Control = ICanControl2;
    using Channel = ICanChannel2;
    using Scheduler = ICanScheduler2;
    using Message = CANMSG2;
    using CyclicMessage = CANCYCLICTXMSG2;
    using Capabilities = CANCAPABILITIES2;
    using LineStatus = CANLINESTATUS2;
    using ChannelStatus = CANCHANSTATUS2;
    using SchedulerStatus = CANSCHEDULERSTATUS2;

    static REFIID socket()
    {
        return IID_ICanSocket2;
    }

    static REFIID control()
    {
        return IID_ICanControl2;
    }

    static REFIID scheduler()
    {
        return IID_ICanScheduler2;
    }

    static HRESULT told(HRESULT result, Message *, UINT32 count, PUINT32 done)
    {
        if (done != nullptr)
            *done = count;
        return result;
    }
};

#include "../flat/can_calls.h"

HRESULT vciGetVersion(PUINT32 major, PUINT32 minor, PUINT32 revision, PUINT32 build)
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

HRESULT canControlDetectBitrate(HANDLE handle, UINT8 mode, UINT8 ex_mode, UINT16 timeout_ms, UINT32 count, PCANBTP sdr,
                                PCANBTP fdr, PUINT32 index)
{
    Use<Control> opened(handle);
    CANBTPTABLE table = {};
    HRESULT result;

    if (!opened)
        return VCI_E_INVHANDLE;
    if (sdr == nullptr || index == nullptr || count > CAN_BTP_TABLE_SIZE)
        return VCI_E_INVALIDARG;
    table.bCount = static_cast<UINT8>(count);
    for (UINT32 k = 0; k < count; k++)
        table.asBTP[k] = {sdr[k], fdr != nullptr ? fdr[k] : CANBTP{}};
    result = opened->control->DetectBaud(mode, ex_mode, timeout_ms, &table);
    *index = result == VCI_OK ? table.bIndex : 0xFFFFFFFF;
    return result;
}

HRESULT canControlInitialize(HANDLE handle, UINT8 mode, UINT8 ex_mode, UINT8 standard, UINT8 extended,
                             UINT32 standard_ids, UINT32 extended_ids, PCANBTP sdr, PCANBTP fdr)
{
    Use<Control> opened(handle);

    if (!opened)
        return VCI_E_INVHANDLE;
    if (sdr == nullptr)
        return VCI_E_INVALIDARG;
    CANINITLINE2 init = {mode,         ex_mode, standard, extended, standard_ids,
                         extended_ids, *sdr,    fdr != nullptr ? *fdr : CANBTP{}};
    return opened->control->InitLine(&init);
}

HRESULT canControlGetFilterMode(HANDLE handle, BOOL extended, PUINT8 into)
{
    Use<Control> opened(handle);

    return opened ? opened->control->GetFilterMode(select_of(extended), into) : VCI_E_INVHANDLE;
}

HRESULT canControlSetFilterMode(HANDLE handle, BOOL extended, UINT8 mode, PUINT8 before)
{
    Use<Control> opened(handle);

    return opened ? opened->control->SetFilterMode(select_of(extended), mode, before) : VCI_E_INVHANDLE;
}

// The control unit of the line that `socket` belongs to, which a channel of it opens.
static HRESULT control_of(ICanSocket2 *socket, ICanChannel2 *channel, PHANDLE into)
{
    Control made = {nullptr, nullptr};
    HRESULT result;

    if (into == nullptr)
        return VCI_E_INVALIDARG;
    *into = nullptr;
    result = channel->GetControl(&made.control);
    if (result != VCI_OK)
        return result;
    made.socket = socket;
    socket->AddRef();
    return keep(made, into);
}

HRESULT canChannelGetControl(HANDLE handle, PHANDLE into)
{
    Use<Channel> opened(handle);

    return opened ? control_of(opened->socket, opened->channel, into) : VCI_E_INVHANDLE;
}

HRESULT canSchedulerGetControl(HANDLE handle, PHANDLE into)
{
    Use<Scheduler> opened(handle);
    ICanChannel2 *channel = nullptr;
    HRESULT result = opened ? opened->socket->CreateChannel(FALSE, &channel) : VCI_E_INVHANDLE;

    if (result == VCI_OK)
        result = control_of(opened->socket, channel, into);
    release(channel);
    return result;
}

HRESULT canChannelInitialize(HANDLE handle, UINT16 receive, UINT16 receive_threshold, UINT16 transmit,
                             UINT16 transmit_threshold, UINT32 filter_size, UINT8 filter_mode)
{
    Use<Channel> opened(handle);
    HRESULT result;

    if (!opened)
        return VCI_E_INVHANDLE;
    opened->received.close();
    opened->to_send.close();
    result = opened->channel->Initialize(receive, transmit, filter_size, filter_mode);
    return result == VCI_OK ? opened->open_queues(receive_threshold, transmit, transmit_threshold) : result;
}

HRESULT canChannelGetFilterMode(HANDLE handle, BOOL extended, PUINT8 into)
{
    Use<Channel> opened(handle);

    return opened ? opened->channel->GetFilterMode(select_of(extended), into) : VCI_E_INVHANDLE;
}

HRESULT canChannelSetFilterMode(HANDLE handle, BOOL extended, UINT8 mode, PUINT8 before)
{
    Use<Channel> opened(handle);

    return opened ? opened->channel->SetFilterMode(select_of(extended), mode, before) : VCI_E_INVHANDLE;
}

HRESULT canChannelSetAccFilter(HANDLE handle, BOOL extended, UINT32 code, UINT32 mask)
{
    Use<Channel> opened(handle);

    return opened ? opened->channel->SetAccFilter(select_of(extended), code, mask) : VCI_E_INVHANDLE;
}

HRESULT canChannelAddFilterIds(HANDLE handle, BOOL extended, UINT32 code, UINT32 mask)
{
    Use<Channel> opened(handle);

    return opened ? opened->channel->AddFilterIds(select_of(extended), code, mask) : VCI_E_INVHANDLE;
}

HRESULT canChannelRemFilterIds(HANDLE handle, BOOL extended, UINT32 code, UINT32 mask)
{
    Use<Channel> opened(handle);

    return opened ? opened->channel->RemFilterIds(select_of(extended), code, mask) : VCI_E_INVHANDLE;
}
