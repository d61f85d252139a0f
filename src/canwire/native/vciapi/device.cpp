#include "device.h"
#include "line.h"

static const UINT32 MOST_AT_ONCE = CW_MOST_DATA / sizeof(VCIDEVICEINFO);

bool BalObject::is(REFIID iid) const
{
    return iid == IID_IBalObject;
}

HRESULT BalObject::GetFeatures(PBALFEATURES into)
{
    return fill("get_features", into);
}

HRESULT BalObject::OpenSocket(UINT32 number, REFIID iid, PVOID *into)
{
    Call call(kind_, "open_socket", remote_);
    HRESULT result;

    if (into == nullptr)
        return VCI_E_INVALIDARG;
    *into = nullptr;
    result = gone() ? VCI_E_INVHANDLE : call.with(number).with(iid).ask();
    return result == VCI_OK ? made_socket(iid, call.made(), into) : result;
}

bool Device::is(REFIID iid) const
{
    return iid == IID_IVciDevice;
}

HRESULT Device::GetDeviceInfo(PVCIDEVICEINFO into)
{
    return fill("get_device_info", into);
}

HRESULT Device::GetDeviceCaps(PVCIDEVICECAPS into)
{
    return fill("get_device_caps", into);
}

HRESULT Device::OpenComponent(REFCLSID component, REFIID iid, PVOID *into)
{
    IBalObject *made = nullptr;
    HRESULT result;

    if (into == nullptr)
        return VCI_E_INVALIDARG;
    result = open<BalObject>("open_component", "BalObject", &made, component, iid);
    *into = made;
    return result;
}

bool EnumDevice::is(REFIID iid) const
{
    return iid == IID_IVciEnumDevice;
}

HRESULT EnumDevice::Next(UINT32 count, PVCIDEVICEINFO into, PUINT32 fetched)
{
    UINT32 asked = count < MOST_AT_ONCE ? count : MOST_AT_ONCE;
    Call call(kind_, "next", remote_);
    HRESULT result;

    if (fetched != nullptr)
        *fetched = 0;
    if (gone())
        return VCI_E_INVHANDLE;
    if ((into == nullptr && count > 0) || (fetched == nullptr && count != 1))
        return VCI_E_INVALIDARG;
    result = call.with(asked).ask(into, asked * sizeof *into);
    if (result == VCI_OK && fetched != nullptr)
        *fetched = call.value();
    return result;
}

HRESULT EnumDevice::Skip(UINT32 count)
{
    return call("skip", count);
}

HRESULT EnumDevice::Reset()
{
    return call("reset");
}

void EnumDevice::close()
{
    if (event_ != nullptr)
        cw_event_forget(event_, watched_);
    event_ = nullptr;
    watched_ = -1;
}

HRESULT EnumDevice::AssignEvent(HANDLE event)
{
    struct cw_event *found = event != nullptr ? cw_event_of(event) : nullptr;
    Call call("", "watch", remote_);
    HRESULT result = VCI_OK;

    if (event != nullptr && found == nullptr)
        return VCI_E_INVHANDLE;
    if (found != nullptr)
        call.with(UINT8(1));
    result = gone() ? VCI_E_INVHANDLE : call.ask();
    if (result == VCI_OK)
        close();
    if (result == VCI_OK && found != nullptr && call.answer()->descriptor_count == 1) {
        watched_ = call.answer()->descriptors[--call.answer()->descriptor_count];
        event_ = found;
        if (cw_event_watch(event_, watched_) < 0) {
            event_ = nullptr;
            result = VCI_E_OUTOFMEMORY;
        }
    }
    if (found != nullptr)
        cw_event_release(found);
    return result;
}

bool DeviceManager::is(REFIID iid) const
{
    return iid == IID_IVciDeviceManager;
}

HRESULT DeviceManager::EnumDevices(IVciEnumDevice **into)
{
    return open<EnumDevice>("enum_devices", "VciEnumDevice", into);
}

HRESULT DeviceManager::OpenDevice(REFVCIID id, IVciDevice **into)
{
    return open<Device>("open_device", "VciDevice", into, id);
}
