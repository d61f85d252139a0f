// The library, its events, and devices: the same in vcinpl and vcinpl2.
#include "handles.h"

#include <vcinpl2.h>

// python-can, and whoever else finds functions by name, takes these without their letter for narrow text
#undef vciFormatError
#undef vciDisplayError
#pragma GCC visibility push(default)
extern "C" void vciFormatError(HRESULT code, PCHAR into, UINT32 room) __attribute__((alias("vciFormatErrorA")));
extern "C" void vciDisplayError(HWND above, PCHAR caption, HRESULT code) __attribute__((alias("vciDisplayErrorA")));
#pragma GCC visibility pop

struct Enumeration {
    IVciEnumDevice *devices;
    HANDLE event;

    void close()
    {
        if (devices != nullptr)
            devices->AssignEvent(nullptr);
        release(devices);
        if (event != nullptr)
            CloseHandle(event);
        event = nullptr;
    }
};

HRESULT open_connector(HANDLE device, UINT8 bus, UINT32 number, REFIID iid, PVOID *into)
{
    Use<Device> opened(device);
    BALFEATURES features;
    HRESULT result = opened ? opened->layer->GetFeatures(&features) : VCI_E_INVHANDLE;

    *into = nullptr;
    for (UINT32 at = 0; result == VCI_OK && at < features.BusSocketCount && at < BAL_MAX_SOCKETS; at++)
        if (VCI_BUS_TYPE(features.BusSocketType[at]) == bus && number-- == 0)
            return opened->layer->OpenSocket(at, iid, into);
    return result == VCI_OK ? VCI_E_INVALIDARG : result;
}

HRESULT vciInitialize(void)
{
    return VciInitialize();
}

void vciFormatErrorA(HRESULT code, PCHAR into, UINT32 room)
{
    VciFormatErrorA(code, into, room);
}

void vciFormatErrorW(HRESULT code, PWCHAR into, UINT32 room)
{
    VciFormatErrorW(code, into, room);
}

void vciDisplayErrorA(HWND above, PCHAR caption, HRESULT code)
{
    char text[VCI_MAX_ERRSTRLEN];

    if (VciFormatErrorA(code, text, sizeof text) == VCI_OK)
        MessageBoxA(above, text, caption, MB_ICONSTOP);
}

void vciDisplayErrorW(HWND above, PWCHAR caption, HRESULT code)
{
    (void)caption; // narrow text alone is shown
    vciDisplayErrorA(above, nullptr, code);
}

HRESULT vciCreateLuid(PVCIID into)
{
    return VciCreateLuid(into);
}

static UINT32 room_of(LONG size)
{
    return size > 0 ? static_cast<UINT32>(size) : 0;
}

HRESULT vciLuidToCharA(REFVCIID id, PCHAR into, LONG room)
{
    return VciLuidToCharA(id, into, room_of(room));
}

HRESULT vciLuidToCharW(REFVCIID id, PWCHAR into, LONG room)
{
    return VciLuidToCharW(id, into, room_of(room));
}

HRESULT vciCharToLuidA(PCHAR text, PVCIID into)
{
    return VciCharToLuidA(text, into);
}

HRESULT vciCharToLuidW(PWCHAR text, PVCIID into)
{
    return VciCharToLuidW(text, into);
}

HRESULT vciGuidToCharA(REFGUID guid, PCHAR into, LONG room)
{
    return VciGuidToCharA(guid, into, room_of(room));
}

HRESULT vciGuidToCharW(REFGUID guid, PWCHAR into, LONG room)
{
    return VciGuidToCharW(guid, into, room_of(room));
}

HRESULT vciCharToGuidA(PCHAR text, PGUID into)
{
    return VciCharToGuidA(text, into);
}

HRESULT vciCharToGuidW(PWCHAR text, PGUID into)
{
    return VciCharToGuidW(text, into);
}

HRESULT vciEventCreate(BOOL manual_reset, BOOL signalled, PHANDLE into)
{
    if (into == nullptr)
        return VCI_E_INVALIDARG;
    *into = CreateEventA(nullptr, manual_reset, signalled, nullptr);
    return *into != nullptr ? VCI_OK : VCI_E_OUTOFMEMORY;
}

HRESULT vciEventDelete(HANDLE event)
{
    return CloseHandle(event) ? VCI_OK : VCI_E_INVHANDLE;
}

HRESULT vciEventSignal(HANDLE event)
{
    return SetEvent(event) ? VCI_OK : VCI_E_INVHANDLE;
}

HRESULT vciEventReset(HANDLE event)
{
    return ResetEvent(event) ? VCI_OK : VCI_E_INVHANDLE;
}

static HRESULT waited(HANDLE event, UINT32 timeout_ms)
{
    DWORD result = WaitForSingleObject(event, timeout_ms);

    return result == WAIT_OBJECT_0 ? VCI_OK : result == WAIT_TIMEOUT ? VCI_E_TIMEOUT : VCI_E_INVHANDLE;
}

HRESULT vciEventWaitFor(HANDLE event, UINT32 timeout_ms)
{
    return waited(event, timeout_ms);
}

static HRESULT enumerate(IVciEnumDevice **into)
{
    IVciDeviceManager *manager = nullptr;
    HRESULT result = VciGetDeviceManager(&manager);

    if (result == VCI_OK)
        result = manager->EnumDevices(into);
    release(manager);
    return result;
}

HRESULT vciEnumDeviceOpen(PHANDLE into)
{
    Enumeration made = {nullptr, nullptr};
    HRESULT result;

    if (into == nullptr)
        return VCI_E_INVALIDARG;
    *into = nullptr;
    result = enumerate(&made.devices);
    if (result == VCI_OK)
        result = vciEventCreate(FALSE, FALSE, &made.event);
    if (result == VCI_OK)
        result = made.devices->AssignEvent(made.event);
    if (result == VCI_OK)
        return keep(made, into);
    made.close();
    return result;
}

HRESULT vciEnumDeviceClose(HANDLE handle)
{
    return close_handle<Enumeration>(handle);
}

HRESULT vciEnumDeviceNext(HANDLE handle, PVCIDEVICEINFO into)
{
    Use<Enumeration> opened(handle);

    return opened ? opened->devices->Next(1, into, nullptr) : VCI_E_INVHANDLE;
}

HRESULT vciEnumDeviceReset(HANDLE handle)
{
    Use<Enumeration> opened(handle);

    return opened ? opened->devices->Reset() : VCI_E_INVHANDLE;
}

HRESULT vciEnumDeviceWaitEvent(HANDLE handle, UINT32 timeout_ms)
{
    Use<Enumeration> opened(handle);

    return opened ? waited(opened->event, timeout_ms) : VCI_E_INVHANDLE;
}

static HRESULT identifier_of(HRESULT found, IVciDevice *device, PVCIID into)
{
    VCIDEVICEINFO info;
    HRESULT result = found == VCI_OK ? device->GetDeviceInfo(&info) : found;

    if (result == VCI_OK)
        *into = info.VciObjectId;
    release(device);
    return result;
}

HRESULT vciFindDeviceByHwid(REFGUID id, PVCIID into)
{
    IVciDevice *device = nullptr;

    return into != nullptr ? identifier_of(VciQueryDeviceByHwid(id, &device), device, into) : VCI_E_INVALIDARG;
}

HRESULT vciFindDeviceByClass(REFGUID device_class, UINT32 instance, PVCIID into)
{
    IVciDevice *device = nullptr;
    HRESULT found = into != nullptr ? VciQueryDeviceByClass(device_class, instance, &device) : VCI_E_INVALIDARG;

    return identifier_of(found, device, into);
}

HRESULT vciSelectDeviceDlg(HWND, PVCIID into)
{
    IVciEnumDevice *devices = nullptr;
    VCIDEVICEINFO info;
    HRESULT result = into != nullptr ? enumerate(&devices) : VCI_E_INVALIDARG;

    if (result == VCI_OK)
        result = devices->Next(1, &info, nullptr);
    if (result == VCI_OK)
        *into = info.VciObjectId;
    release(devices);
    return result;
}

HRESULT vciDeviceOpen(REFVCIID id, PHANDLE into)
{
    IVciDeviceManager *manager = nullptr;
    Device made = {nullptr, nullptr};
    HRESULT result;

    if (into == nullptr)
        return VCI_E_INVALIDARG;
    *into = nullptr;
    result = VciGetDeviceManager(&manager);
    if (result == VCI_OK)
        result = manager->OpenDevice(id, &made.device);
    if (result == VCI_OK)
        result = made.device->OpenComponent(CLSID_VCIBAL, IID_IBalObject, reinterpret_cast<PVOID *>(&made.layer));
    release(manager);
    if (result == VCI_OK)
        return keep(made, into);
    made.close();
    return result;
}

HRESULT vciDeviceOpenDlg(HWND above, PHANDLE into)
{
    VCIID id;
    HRESULT result = vciSelectDeviceDlg(above, &id);

    return result == VCI_OK ? vciDeviceOpen(id, into) : result;
}

HRESULT vciDeviceClose(HANDLE handle)
{
    return close_handle<Device>(handle);
}

HRESULT vciDeviceGetInfo(HANDLE handle, PVCIDEVICEINFO into)
{
    Use<Device> opened(handle);

    return opened ? opened->device->GetDeviceInfo(into) : VCI_E_INVHANDLE;
}

HRESULT vciDeviceGetCaps(HANDLE handle, PVCIDEVICECAPS into)
{
    Use<Device> opened(handle);

    return opened ? opened->device->GetDeviceCaps(into) : VCI_E_INVHANDLE;
}
