// What connectors of boards have: sockets, control units, channels, monitors, transmit lists.
#pragma once

#include "fifo.h"

// An interface of a connector by its IID, once a call has opened it; VCI_E_NOINTERFACE for what is none.
HRESULT made_socket(REFIID iid, Remote remote, PVOID *into);

template <class Interface, const GUID &OWN> class LineObject : public Object<Interface> {
public:
    using Object<Interface>::Object;

protected:
    bool is(REFIID iid) const override
    {
        return iid == OWN;
    }
};

// ICanControl, ICanControl2, ILinControl
template <class Interface, const GUID &OWN, class Init, class Status> class Control : public LineObject<Interface, OWN> {
public:
    using LineObject<Interface, OWN>::LineObject;

    HRESULT InitLine(Init *init) override
    {
        return init != nullptr ? this->call("init_line", *init) : VCI_E_INVALIDARG;
    }

    HRESULT ResetLine() override
    {
        return this->call("reset_line");
    }

    HRESULT StartLine() override
    {
        return this->call("start_line");
    }

    HRESULT StopLine() override
    {
        return this->call("stop_line");
    }

    HRESULT GetLineStatus(Status *into) override
    {
        return this->fill("get_line_status", into);
    }
};

// the filters of control units and channels; Base is what they are besides
template <class Base> class Filters : public Base {
public:
    using Base::Base;

    HRESULT SetAccFilter(UINT8 select, UINT32 code, UINT32 mask) override
    {
        return this->call("set_acc_filter", select, code, mask);
    }

    HRESULT AddFilterIds(UINT8 select, UINT32 code, UINT32 mask) override
    {
        return this->call("add_filter_ids", select, code, mask);
    }

    HRESULT RemFilterIds(UINT8 select, UINT32 code, UINT32 mask) override
    {
        return this->call("rem_filter_ids", select, code, mask);
    }
};

template <class Base> class FilterModes : public Filters<Base> {
public:
    using Filters<Base>::Filters;

    HRESULT GetFilterMode(UINT8 select, PUINT8 into) override
    {
        return into != nullptr ? this->number("get_filter_mode", into, select) : VCI_E_INVALIDARG;
    }

    HRESULT SetFilterMode(UINT8 select, UINT8 mode, PUINT8 before) override
    {
        return this->number("set_filter_mode", before, select, mode);
    }
};

// ICanChannel, ICanChannel2, ILinMonitor
template <class Interface, const GUID &OWN, class Status> class Queues : public LineObject<Interface, OWN> {
public:
    using LineObject<Interface, OWN>::LineObject;

    HRESULT Activate() override
    {
        return this->call("activate");
    }

    HRESULT Deactivate() override
    {
        return this->call("deactivate");
    }

    HRESULT GetReader(IFifoReader **into) override
    {
        return end("get_reader", IID_IFifoReader, into);
    }

    HRESULT GetStatus(Status *into) override
    {
        return this->fill("get_status", into);
    }

protected:
    template <class Pointer> HRESULT end(const char *method, REFIID iid, Pointer **into)
    {
        Call call(this->kind_, method, this->remote_);
        PVOID made = nullptr;
        HRESULT result;

        if (into == nullptr)
            return VCI_E_INVALIDARG;
        *into = nullptr;
        if (this->gone())
            return VCI_E_INVHANDLE;
        result = open_fifo(call, iid, &made);
        *into = static_cast<Pointer *>(made);
        return result;
    }
};

// ICanSocket, ICanSocket2, ILinSocket
template <class Interface, const GUID &OWN, class Capabilities, class Status>
class Socket : public LineObject<Interface, OWN> {
public:
    using LineObject<Interface, OWN>::LineObject;

    HRESULT GetSocketInfo(PBALSOCKETINFO into) override
    {
        return this->fill("get_socket_info", into);
    }

    HRESULT GetCapabilities(Capabilities *into) override
    {
        return this->fill("get_capabilities", into);
    }

    HRESULT GetLineStatus(Status *into) override
    {
        return this->fill("get_line_status", into);
    }
};
