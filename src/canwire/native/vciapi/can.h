// CAN connectors, with and without CAN FD.
#pragma once

#include "line.h"

class CanControl : public Filters<Control<ICanControl, IID_ICanControl, CANINITLINE, CANLINESTATUS>> {
public:
    using Filters::Filters;
    HRESULT DetectBaud(UINT16 timeout_ms, PCANBTRTABLE table) override;
};

class CanControl2 : public FilterModes<Control<ICanControl2, IID_ICanControl2, CANINITLINE2, CANLINESTATUS2>> {
public:
    using FilterModes::FilterModes;
    HRESULT DetectBaud(UINT8 mode, UINT8 ex_mode, UINT16 timeout_ms, PCANBTPTABLE table) override;
};

class CanChannel : public Queues<ICanChannel, IID_ICanChannel, CANCHANSTATUS> {
public:
    using Queues::Queues;
    HRESULT Initialize(UINT16 receive, UINT16 transmit) override;
    HRESULT GetWriter(IFifoWriter **into) override;
};

class CanChannel2 : public FilterModes<Queues<ICanChannel2, IID_ICanChannel2, CANCHANSTATUS2>> {
public:
    using FilterModes::FilterModes;
    HRESULT Initialize(UINT32 receive, UINT32 transmit, UINT32 filter_size, UINT8 filter_mode) override;
    HRESULT GetWriter(IFifoWriter **into) override;
    HRESULT GetControl(ICanControl2 **into) override;
};

class CanSocket : public Socket<ICanSocket, IID_ICanSocket, CANCAPABILITIES, CANLINESTATUS> {
public:
    using Socket::Socket;
    HRESULT CreateChannel(BOOL exclusive, ICanChannel **into) override;
};

class CanSocket2 : public Socket<ICanSocket2, IID_ICanSocket2, CANCAPABILITIES2, CANLINESTATUS2> {
public:
    using Socket::Socket;
    HRESULT CreateChannel(BOOL exclusive, ICanChannel2 **into) override;
};

template <class Interface, const GUID &IID, class Message, class Status>
class Scheduler : public LineObject<Interface, IID> {
public:
    using LineObject<Interface, IID>::LineObject;

    HRESULT Resume() override
    {
        return this->call("resume");
    }

    HRESULT Suspend() override
    {
        return this->call("suspend");
    }

    HRESULT Reset() override
    {
        return this->call("reset");
    }

    HRESULT GetStatus(Status *into) override
    {
        return this->fill("get_status", into);
    }

    HRESULT AddMessage(Message *message, PUINT32 index) override
    {
        if (message == nullptr || index == nullptr)
            return VCI_E_INVALIDARG;
        *index = 0xFFFFFFFF;
        return this->number("add_message", index, *message);
    }

    HRESULT RemMessage(UINT32 index) override
    {
        return this->call("rem_message", index);
    }

    HRESULT StartMessage(UINT32 index, UINT32 count) override
    {
        return this->call("start_message", index, count);
    }

    HRESULT StopMessage(UINT32 index) override
    {
        return this->call("stop_message", index);
    }
};

using CanScheduler = Scheduler<ICanScheduler, IID_ICanScheduler, CANCYCLICTXMSG, CANSCHEDULERSTATUS>;
using CanScheduler2 = Scheduler<ICanScheduler2, IID_ICanScheduler2, CANCYCLICTXMSG2, CANSCHEDULERSTATUS2>;
