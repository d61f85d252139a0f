// Boards, their list, and the access layer of one.
#pragma once

#include "object.h"

class BalObject : public Object<IBalObject> {
public:
    using Object::Object;
    HRESULT GetFeatures(PBALFEATURES into) override;
    HRESULT OpenSocket(UINT32 number, REFIID iid, PVOID *into) override;

protected:
    bool is(REFIID iid) const override;
};

class Device : public Object<IVciDevice> {
public:
    using Object::Object;
    HRESULT GetDeviceInfo(PVCIDEVICEINFO into) override;
    HRESULT GetDeviceCaps(PVCIDEVICECAPS into) override;
    HRESULT OpenComponent(REFCLSID component, REFIID iid, PVOID *into) override;

protected:
    bool is(REFIID iid) const override;
};

class EnumDevice : public Object<IVciEnumDevice> {
public:
    using Object::Object;
    HRESULT Next(UINT32 count, PVCIDEVICEINFO into, PUINT32 fetched) override;
    HRESULT Skip(UINT32 count) override;
    HRESULT Reset() override;
    HRESULT AssignEvent(HANDLE event) override;

protected:
    bool is(REFIID iid) const override;
    void close() override;

private:
    struct cw_event *event_ = nullptr;
    int watched_ = -1; // readable whenever a board comes or goes
};

class DeviceManager : public Object<IVciDeviceManager> {
public:
    using Object::Object;
    HRESULT EnumDevices(IVciEnumDevice **into) override;
    HRESULT OpenDevice(REFVCIID id, IVciDevice **into) override;

protected:
    bool is(REFIID iid) const override;
};
