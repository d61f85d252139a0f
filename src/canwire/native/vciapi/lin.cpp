#include "lin.h"

HRESULT LinControl::WriteMessage(BOOL send, PLINMSG message)
{
    return message != nullptr ? call("write_message", send, *message) : VCI_E_INVALIDARG;
}

HRESULT LinMonitor::Initialize(UINT16 receive)
{
    return call("initialize", receive);
}

HRESULT LinSocket::CreateMonitor(BOOL exclusive, ILinMonitor **into)
{
    return open<LinMonitor>("create_monitor", "LinMonitor", into, exclusive);
}
