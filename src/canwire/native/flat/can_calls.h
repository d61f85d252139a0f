// The functions that vcinpl and vcinpl2 have by the same names: included once in each, where Api says whose types.
#include "can.h"

using Message = Api::Message;
using Control = CanControl<Api>;
using Channel = CanChannel<Api>;
using Scheduler = CanScheduler<Api>;

HRESULT canControlOpen(HANDLE device, UINT32 number, PHANDLE into)
{
    return open_can<Api>(device, number, Api::control(), &Control::control, into);
}

HRESULT canControlClose(HANDLE handle)
{
    return close_handle<Control>(handle);
}

HRESULT canControlGetCaps(HANDLE handle, Api::Capabilities *into)
{
    Use<Control> opened(handle);

    return opened ? opened->socket->GetCapabilities(into) : VCI_E_INVHANDLE;
}

HRESULT canControlGetStatus(HANDLE handle, Api::LineStatus *into)
{
    Use<Control> opened(handle);

    return opened ? opened->control->GetLineStatus(into) : VCI_E_INVHANDLE;
}

HRESULT canControlReset(HANDLE handle)
{
    Use<Control> opened(handle);

    return opened ? opened->control->ResetLine() : VCI_E_INVHANDLE;
}

HRESULT canControlStart(HANDLE handle, BOOL start)
{
    Use<Control> opened(handle);

    return !opened ? VCI_E_INVHANDLE : start ? opened->control->StartLine() : opened->control->StopLine();
}

HRESULT canControlSetAccFilter(HANDLE handle, BOOL extended, UINT32 code, UINT32 mask)
{
    Use<Control> opened(handle);

    return opened ? opened->control->SetAccFilter(select_of(extended), code, mask) : VCI_E_INVHANDLE;
}

HRESULT canControlAddFilterIds(HANDLE handle, BOOL extended, UINT32 code, UINT32 mask)
{
    Use<Control> opened(handle);

    return opened ? opened->control->AddFilterIds(select_of(extended), code, mask) : VCI_E_INVHANDLE;
}

HRESULT canControlRemFilterIds(HANDLE handle, BOOL extended, UINT32 code, UINT32 mask)
{
    Use<Control> opened(handle);

    return opened ? opened->control->RemFilterIds(select_of(extended), code, mask) : VCI_E_INVHANDLE;
}

HRESULT canChannelOpen(HANDLE device, UINT32 number, BOOL exclusive, PHANDLE into)
{
    Channel made = {};
    HRESULT result;

    if (into == nullptr)
        return VCI_E_INVALIDARG;
    *into = nullptr;
    result = open_connector(device, VCI_BUS_CAN, number, Api::socket(), reinterpret_cast<PVOID *>(&made.socket));
    if (result == VCI_OK)
        result = made.socket->CreateChannel(exclusive, &made.channel);
    if (result == VCI_OK)
        return keep(made, into);
    made.close();
    return result;
}

HRESULT canChannelClose(HANDLE handle)
{
    {
        Use<Channel> opened(handle);

        if (opened) {
            opened->received.end_waits();
            opened->to_send.end_waits();
        }
    }
    return close_handle<Channel>(handle);
}

HRESULT canChannelGetCaps(HANDLE handle, Api::Capabilities *into)
{
    Use<Channel> opened(handle);

    return opened ? opened->socket->GetCapabilities(into) : VCI_E_INVHANDLE;
}

HRESULT canChannelGetStatus(HANDLE handle, Api::ChannelStatus *into)
{
    Use<Channel> opened(handle);

    return opened ? opened->channel->GetStatus(into) : VCI_E_INVHANDLE;
}

HRESULT canChannelActivate(HANDLE handle, BOOL enable)
{
    Use<Channel> opened(handle);

    return !opened ? VCI_E_INVHANDLE : enable ? opened->channel->Activate() : opened->channel->Deactivate();
}

HRESULT canChannelPeekMessage(HANDLE handle, Message *into)
{
    return canChannelPeekMsgMult(handle, into, 1, nullptr);
}

HRESULT canChannelPeekMsgMult(HANDLE handle, Message into[], UINT32 count, PUINT32 done)
{
    return on_reader<Api>(handle, into, [&](Reading<Message> &queue) {
        UINT32 got = 0;
        return Api::told(queue.peek(into, count, &got), into, got, done);
    });
}

HRESULT canChannelPostMessage(HANDLE handle, Message *message)
{
    return canChannelPostMsgMult(handle, message, 1, nullptr);
}

HRESULT canChannelPostMsgMult(HANDLE handle, Message messages[], UINT32 count, PUINT32 done)
{
    return on_writer<Api>(handle, messages, [&](Writing<Message> &queue) { return queue.post(messages, count, done); });
}

HRESULT canChannelWaitRxEvent(HANDLE handle, UINT32 timeout_ms)
{
    return on_reader<Api>(handle, &timeout_ms, [&](Reading<Message> &queue) { return queue.wait_for_some(timeout_ms); });
}

HRESULT canChannelWaitTxEvent(HANDLE handle, UINT32 timeout_ms)
{
    return on_writer<Api>(handle, &timeout_ms, [&](Writing<Message> &queue) { return queue.wait_for_room(timeout_ms); });
}

HRESULT canChannelReadMessage(HANDLE handle, UINT32 timeout_ms, Message *into)
{
    return canChannelReadMsgMult(handle, timeout_ms, into, 1, nullptr);
}

HRESULT canChannelReadMsgMult(HANDLE handle, UINT32 timeout_ms, Message into[], UINT32 count, PUINT32 done)
{
    return on_reader<Api>(handle, into, [&](Reading<Message> &queue) {
        UINT32 got = 0;
        return Api::told(queue.read(timeout_ms, into, count, &got), into, got, done);
    });
}

HRESULT canChannelSendMessage(HANDLE handle, UINT32 timeout_ms, Message *message)
{
    return canChannelSendMsgMult(handle, timeout_ms, message, 1, nullptr);
}

HRESULT canChannelSendMsgMult(HANDLE handle, UINT32 timeout_ms, Message messages[], UINT32 count, PUINT32 done)
{
    return on_writer<Api>(handle, messages,
                          [&](Writing<Message> &queue) { return queue.send(timeout_ms, messages, count, done); });
}

HRESULT canSchedulerOpen(HANDLE device, UINT32 number, PHANDLE into)
{
    return open_can<Api>(device, number, Api::scheduler(), &Scheduler::scheduler, into);
}

HRESULT canSchedulerClose(HANDLE handle)
{
    return close_handle<Scheduler>(handle);
}

HRESULT canSchedulerGetCaps(HANDLE handle, Api::Capabilities *into)
{
    Use<Scheduler> opened(handle);

    return opened ? opened->socket->GetCapabilities(into) : VCI_E_INVHANDLE;
}

HRESULT canSchedulerGetStatus(HANDLE handle, Api::SchedulerStatus *into)
{
    Use<Scheduler> opened(handle);

    return opened ? opened->scheduler->GetStatus(into) : VCI_E_INVHANDLE;
}

HRESULT canSchedulerActivate(HANDLE handle, BOOL enable)
{
    Use<Scheduler> opened(handle);

    return !opened ? VCI_E_INVHANDLE : enable ? opened->scheduler->Resume() : opened->scheduler->Suspend();
}

HRESULT canSchedulerReset(HANDLE handle)
{
    Use<Scheduler> opened(handle);

    return opened ? opened->scheduler->Reset() : VCI_E_INVHANDLE;
}

HRESULT canSchedulerAddMessage(HANDLE handle, Api::CyclicMessage *message, PUINT32 index)
{
    Use<Scheduler> opened(handle);

    return opened ? opened->scheduler->AddMessage(message, index) : VCI_E_INVHANDLE;
}

HRESULT canSchedulerRemMessage(HANDLE handle, UINT32 index)
{
    Use<Scheduler> opened(handle);

    return opened ? opened->scheduler->RemMessage(index) : VCI_E_INVHANDLE;
}

HRESULT canSchedulerStartMessage(HANDLE handle, UINT32 index, UINT16 repeat)
{
    Use<Scheduler> opened(handle);

    return opened ? opened->scheduler->StartMessage(index, repeat) : VCI_E_INVHANDLE;
}

HRESULT canSchedulerStopMessage(HANDLE handle, UINT32 index)
{
    Use<Scheduler> opened(handle);

    return opened ? opened->scheduler->StopMessage(index) : VCI_E_INVHANDLE;
}
