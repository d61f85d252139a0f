#include "can.h"

HRESULT CanControl::DetectBaud(UINT16 timeout_ms, PCANBTRTABLE table)
{
    CANBTRTABLE found;
    HRESULT result = table != nullptr ? fill("detect_baud", &found, timeout_ms, *table) : VCI_E_INVALIDARG;

    if (result == VCI_OK)
        *table = found;
    return result;
}

HRESULT CanControl2::DetectBaud(UINT8 mode, UINT8 ex_mode, UINT16 timeout_ms, PCANBTPTABLE table)
{
    CANBTPTABLE found;
    HRESULT result = table != nullptr ? fill("detect_baud", &found, mode, ex_mode, timeout_ms, *table) : VCI_E_INVALIDARG;

    if (result == VCI_OK)
        *table = found;
    return result;
}

HRESULT CanChannel::Initialize(UINT16 receive, UINT16 transmit)
{
    return call("initialize", receive, transmit);
}

HRESULT CanChannel::GetWriter(IFifoWriter **into)
{
    return end("get_writer", IID_IFifoWriter, into);
}

HRESULT CanChannel2::Initialize(UINT32 receive, UINT32 transmit, UINT32 filter_size, UINT8 filter_mode)
{
    return call("initialize", receive, transmit, filter_size, filter_mode);
}

HRESULT CanChannel2::GetWriter(IFifoWriter **into)
{
    return end("get_writer", IID_IFifoWriter, into);
}

HRESULT CanChannel2::GetControl(ICanControl2 **into)
{
    return open<CanControl2>("get_control", "CanControl2", into);
}

HRESULT CanSocket::CreateChannel(BOOL exclusive, ICanChannel **into)
{
    return open<CanChannel>("create_channel", "CanChannel", into, exclusive);
}

HRESULT CanSocket2::CreateChannel(BOOL exclusive, ICanChannel2 **into)
{
    return open<CanChannel2>("create_channel", "CanChannel2", into, exclusive);
}
