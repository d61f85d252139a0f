// LIN lines: the same in vcinpl and vcinpl2.
#include "queue.h"

#include <vcinpl2.h>

struct LinControl {
    ILinControl *control;
    ILinSocket *socket;

    void close()
    {
        release(control);
        release(socket);
    }
};

struct LinMonitor {
    ILinMonitor *monitor;
    ILinSocket *socket;
    Reading<LINMSG> received;

    void close()
    {
        received.close();
        release(monitor);
        release(socket);
    }
};

static HRESULT open_lin(HANDLE device, UINT32 number, ILinSocket **into)
{
    return open_connector(device, VCI_BUS_LIN, number, IID_ILinSocket, reinterpret_cast<PVOID *>(into));
}

HRESULT linControlOpen(HANDLE device, UINT32 number, PHANDLE into)
{
    LinControl made = {nullptr, nullptr};
    HRESULT result = into != nullptr ? open_lin(device, number, &made.socket) : VCI_E_INVALIDARG;

    if (result == VCI_OK)
        result = open_connector(device, VCI_BUS_LIN, number, IID_ILinControl, reinterpret_cast<PVOID *>(&made.control));
    if (result == VCI_OK)
        return keep(made, into);
    made.close();
    return result;
}

HRESULT linControlClose(HANDLE handle)
{
    return close_handle<LinControl>(handle);
}

HRESULT linControlGetCaps(HANDLE handle, PLINCAPABILITIES into)
{
    Use<LinControl> opened(handle);

    return opened ? opened->socket->GetCapabilities(into) : VCI_E_INVHANDLE;
}

HRESULT linControlGetStatus(HANDLE handle, PLINLINESTATUS into)
{
    Use<LinControl> opened(handle);

    return opened ? opened->control->GetLineStatus(into) : VCI_E_INVHANDLE;
}

HRESULT linControlInitialize(HANDLE handle, UINT8 mode, UINT16 bit_rate)
{
    Use<LinControl> opened(handle);
    LININITLINE init = {mode, 0, bit_rate};

    return opened ? opened->control->InitLine(&init) : VCI_E_INVHANDLE;
}

HRESULT linControlReset(HANDLE handle)
{
    Use<LinControl> opened(handle);

    return opened ? opened->control->ResetLine() : VCI_E_INVHANDLE;
}

HRESULT linControlStart(HANDLE handle, BOOL start)
{
    Use<LinControl> opened(handle);

    return !opened ? VCI_E_INVHANDLE : start ? opened->control->StartLine() : opened->control->StopLine();
}

HRESULT linControlWriteMessage(HANDLE handle, BOOL send, PLINMSG message)
{
    Use<LinControl> opened(handle);

    return opened ? opened->control->WriteMessage(send, message) : VCI_E_INVHANDLE;
}

HRESULT linMonitorOpen(HANDLE device, UINT32 number, BOOL exclusive, PHANDLE into)
{
    LinMonitor made = {};
    HRESULT result = into != nullptr ? open_lin(device, number, &made.socket) : VCI_E_INVALIDARG;

    if (result == VCI_OK)
        result = made.socket->CreateMonitor(exclusive, &made.monitor);
    if (result == VCI_OK)
        return keep(made, into);
    made.close();
    return result;
}

HRESULT linMonitorClose(HANDLE handle)
{
    {
        Use<LinMonitor> opened(handle);

        if (opened)
            opened->received.end_waits();
    }
    return close_handle<LinMonitor>(handle);
}

HRESULT linMonitorGetCaps(HANDLE handle, PLINCAPABILITIES into)
{
    Use<LinMonitor> opened(handle);

    return opened ? opened->socket->GetCapabilities(into) : VCI_E_INVHANDLE;
}

HRESULT linMonitorGetStatus(HANDLE handle, PLINMONITORSTATUS into)
{
    Use<LinMonitor> opened(handle);

    return opened ? opened->monitor->GetStatus(into) : VCI_E_INVHANDLE;
}

HRESULT linMonitorInitialize(HANDLE handle, UINT16 receive, UINT16 threshold)
{
    Use<LinMonitor> opened(handle);
    HRESULT result;

    if (!opened)
        return VCI_E_INVHANDLE;
    opened->received.close();
    result = opened->monitor->Initialize(receive);
    if (result == VCI_OK)
        result = opened->monitor->GetReader(&opened->received.end);
    return result == VCI_OK ? opened->received.open(threshold) : result;
}

HRESULT linMonitorActivate(HANDLE handle, BOOL enable)
{
    Use<LinMonitor> opened(handle);

    return !opened ? VCI_E_INVHANDLE : enable ? opened->monitor->Activate() : opened->monitor->Deactivate();
}

// An initialised monitor's queue, or why there is none.
template <class Action> static HRESULT on_queue(HANDLE handle, const void *into, Action action)
{
    Use<LinMonitor> opened(handle);

    if (!opened)
        return VCI_E_INVHANDLE;
    if (into == nullptr)
        return VCI_E_INVALIDARG;
    return opened->received.end != nullptr ? action(opened->received) : VCI_E_NOT_INITIALIZED;
}

HRESULT linMonitorPeekMessage(HANDLE handle, PLINMSG into)
{
    return on_queue(handle, into, [&](Reading<LINMSG> &queue) { return queue.peek(into, 1, nullptr); });
}

HRESULT linMonitorPeekMsgMult(HANDLE handle, LINMSG into[], UINT32 count, PUINT32 done)
{
    return on_queue(handle, into, [&](Reading<LINMSG> &queue) { return queue.peek(into, count, done); });
}

HRESULT linMonitorWaitRxEvent(HANDLE handle, UINT32 timeout_ms)
{
    return on_queue(handle, &timeout_ms, [&](Reading<LINMSG> &queue) { return queue.wait_for_some(timeout_ms); });
}

HRESULT linMonitorReadMessage(HANDLE handle, UINT32 timeout_ms, PLINMSG into)
{
    return on_queue(handle, into, [&](Reading<LINMSG> &queue) { return queue.read(timeout_ms, into, 1, nullptr); });
}

HRESULT linMonitorReadMsgMult(HANDLE handle, UINT32 timeout_ms, LINMSG into[], UINT32 count, PUINT32 done)
{
    return on_queue(handle, into, [&](Reading<LINMSG> &queue) { return queue.read(timeout_ms, into, count, done); });
}
