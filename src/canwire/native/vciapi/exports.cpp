// The exported functions: everything starts here.
#include "device.h"
#include "fifo.h"

#include <time.h>

HRESULT VciInitialize(void)
{
    return Call("", "initialize").ask();
}

HRESULT VciGetVersion(PVCIVERSIONINFO into)
{
    return into != nullptr ? Call("", "get_version").ask(into, sizeof *into) : VCI_E_INVALIDARG;
}

HRESULT VciCreateLuid(PVCIID into)
{
    return into != nullptr ? Call("", "create_luid").ask(into, sizeof *into) : VCI_E_INVALIDARG;
}

template <class Class, class Pointer> static HRESULT opened(Call &call, const char *kind, Pointer **into)
{
    HRESULT result;

    if (into == nullptr)
        return VCI_E_INVALIDARG;
    *into = nullptr;
    result = call.ask();
    if (result == VCI_OK && (*into = new Class(kind, call.made())) == nullptr)
        result = VCI_E_OUTOFMEMORY;
    return result;
}

HRESULT VciGetDeviceManager(IVciDeviceManager **into)
{
    Call call("", "get_device_manager");

    return opened<DeviceManager>(call, "VciDeviceManager", into);
}

HRESULT VciQueryDeviceByHwid(REFGUID id, IVciDevice **into)
{
    Call call("", "query_device_by_hwid");

    return opened<Device>(call.with(id), "VciDevice", into);
}

HRESULT VciQueryDeviceByClass(REFGUID device_class, UINT32 instance, IVciDevice **into)
{
    Call call("", "query_device_by_class");

    return opened<Device>(call.with(device_class).with(instance), "VciDevice", into);
}

HRESULT VciCreateFifo(PVCIID id, UINT16 capacity, UINT16 size, REFIID iid, PVOID *into)
{
    Call call("", "create_fifo");

    if (id == nullptr || into == nullptr)
        return VCI_E_INVALIDARG;
    return open_fifo(call.with(capacity).with(size).with(iid), iid, into, id, sizeof *id);
}

HRESULT VciAccessFifo(REFVCIID id, REFIID iid, PVOID *into)
{
    Call call("", "access_fifo");

    return into != nullptr ? open_fifo(call.with(id).with(iid), iid, into) : VCI_E_INVALIDARG;
}

// What the vendor's header has beside the manual: a counter of microseconds, and the time in units of 100 ns since 1601.
// Both go by the hub's time in a program that keeps one with others.
static UINT64 clock_ns(clockid_t clock)
{
    INT64 kept = cw_timed() ? cw_hub_now() : -1;
    struct timespec now;

    if (kept >= 0)
        return static_cast<UINT64>(kept);
    clock_gettime(clock, &now);
    return static_cast<UINT64>(now.tv_sec) * 1000000000 + static_cast<UINT64>(now.tv_nsec);
}

UINT64 VciQueryTickCounter(void)
{
    return clock_ns(CLOCK_MONOTONIC) / 1000;
}

UINT32 VciQueryTickFrequency(void)
{
    return 1000000;
}

UINT64 VciQueryCurrentTime(void)
{
    return clock_ns(CLOCK_REALTIME) / 100 + 116444736000000000ull;
}
