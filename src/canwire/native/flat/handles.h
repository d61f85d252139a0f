// Handles of the flat interface: each keeps COM interfaces of vciapi, which are released with it.
#pragma once

#include "canwire.h"

#include <vcisdk.h>

template <class Interface> void release(Interface *&held)
{
    if (held != nullptr)
        held->Release();
    held = nullptr;
}

// What a handle stands for; Body has close().
template <class Body> struct Box {
    struct cw_object head;
    Body body;
};

template <class Body> void destroy_box(struct cw_object *object)
{
    reinterpret_cast<Box<Body> *>(object)->body.close();
    free(object);
}

template <class Body> inline const struct cw_kind kind_of = {"VCI", destroy_box<Body>, nullptr, nullptr};

// A handle for this body, which is closed where there is no memory for one.
template <class Body> HRESULT keep(Body &body, PHANDLE into)
{
    Box<Body> *box = static_cast<Box<Body> *>(calloc(1, sizeof *box));

    if (box == nullptr) {
        body.close();
        return VCI_E_OUTOFMEMORY;
    }
    *box = {{&kind_of<Body>, 1}, body};
    *into = cw_handle_new(&box->head);
    if (*into == nullptr)
        cw_object_release(&box->head);
    return *into != nullptr ? VCI_OK : VCI_E_OUTOFMEMORY;
}

// The body of a handle for the time of one call; false where it is none of these.
template <class Body> class Use {
public:
    explicit Use(HANDLE handle) : box_(reinterpret_cast<Box<Body> *>(cw_handle_get(handle, &kind_of<Body>)))
    {
    }

    ~Use()
    {
        if (box_ != nullptr)
            cw_object_release(&box_->head);
    }

    Use(const Use &) = delete;

    explicit operator bool() const
    {
        return box_ != nullptr;
    }

    Body *operator->() const
    {
        return &box_->body;
    }

private:
    Box<Body> *box_;
};

template <class Body> HRESULT close_handle(HANDLE handle)
{
    struct cw_object *found = cw_handle_get(handle, &kind_of<Body>);

    if (found == nullptr)
        return VCI_E_INVHANDLE;
    cw_object_release(found);
    return cw_handle_close(handle) == 0 ? VCI_OK : VCI_E_INVHANDLE;
}

struct Device {
    IVciDevice *device;
    IBalObject *layer;

    void close()
    {
        release(layer);
        release(device);
    }
};

// Number `number` of a device's connectors to this bus (VCI_BUS_), by an interface; VCI_E_INVALIDARG for none.
HRESULT open_connector(HANDLE device, UINT8 bus, UINT32 number, REFIID iid, PVOID *into);

// The end of a wait that begins now.
class Deadline {
public:
    explicit Deadline(UINT32 milliseconds) : for_ever_(milliseconds == INFINITE), until_(GetTickCount64() + milliseconds)
    {
    }

    DWORD left() const
    {
        ULONGLONG now = GetTickCount64();

        return for_ever_ ? INFINITE : now < until_ ? static_cast<DWORD>(until_ - now) : 0;
    }

private:
    bool for_ever_;
    ULONGLONG until_;
};
