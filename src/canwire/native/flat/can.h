// CAN lines, for CANMSG (vcinpl) and CANMSG2 (vcinpl2): what both have in common, over the types that Api names.
#pragma once

#include "queue.h"

template <class Api> struct CanControl {
    typename Api::Control *control;
    typename Api::Socket *socket;

    void close()
    {
        release(control);
        release(socket);
    }
};

template <class Api> struct CanChannel {
    typename Api::Channel *channel;
    typename Api::Socket *socket;
    Reading<typename Api::Message> received;
    Writing<typename Api::Message> to_send;

    void close()
    {
        received.close();
        to_send.close();
        release(channel);
        release(socket);
    }

    // after Initialize: the ends of the new queues
    HRESULT open_queues(UINT16 receive_threshold, UINT16 transmit, UINT16 transmit_threshold)
    {
        HRESULT result = channel->GetReader(&received.end);

        if (result == VCI_OK)
            result = received.open(receive_threshold);
        if (result == VCI_OK && transmit > 0)
            result = channel->GetWriter(&to_send.end);
        return result == VCI_OK && transmit > 0 ? to_send.open(transmit_threshold) : result;
    }
};

template <class Api> struct CanScheduler {
    typename Api::Scheduler *scheduler;
    typename Api::Socket *socket;

    void close()
    {
        release(scheduler);
        release(socket);
    }
};

// A control unit or scheduler, with the socket that tells what its line can do.
template <class Api, class Body, class Interface>
HRESULT open_can(HANDLE device, UINT32 number, REFIID iid, Interface *Body::*part, PHANDLE into)
{
    Body made = {};
    HRESULT result;

    if (into == nullptr)
        return VCI_E_INVALIDARG;
    *into = nullptr;
    result = open_connector(device, VCI_BUS_CAN, number, Api::socket(), reinterpret_cast<PVOID *>(&made.socket));
    if (result == VCI_OK)
        result = open_connector(device, VCI_BUS_CAN, number, iid, reinterpret_cast<PVOID *>(&(made.*part)));
    if (result == VCI_OK)
        return keep(made, into);
    made.close();
    return result;
}

inline UINT8 select_of(BOOL extended)
{
    return extended ? CAN_FILTER_EXT : CAN_FILTER_STD;
}

template <class Api, class Action> HRESULT on_reader(HANDLE handle, const void *into, Action action)
{
    Use<CanChannel<Api>> opened(handle);

    if (!opened)
        return VCI_E_INVHANDLE;
    if (into == nullptr)
        return VCI_E_INVALIDARG;
    return opened->received.end != nullptr ? action(opened->received) : VCI_E_NOT_INITIALIZED;
}

template <class Api, class Action> HRESULT on_writer(HANDLE handle, const void *messages, Action action)
{
    Use<CanChannel<Api>> opened(handle);

    if (!opened)
        return VCI_E_INVHANDLE;
    if (messages == nullptr)
        return VCI_E_INVALIDARG;
    if (opened->to_send.end != nullptr)
        return action(opened->to_send);
    return opened->received.end != nullptr ? VCI_E_INVALID_STATE : VCI_E_NOT_INITIALIZED;
}
