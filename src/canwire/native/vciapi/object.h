// What all objects have in common: references, interfaces, and that a released one gives an error instead of a crash.
#pragma once

#include "call.h"

// Memory of objects: what was released last is kept for a while (object.cpp).
void *new_object(size_t size);
void retire_object(void *object);

// An interface of the helper's, made of a call that opened it. Count and state belong to any number of threads.
template <class Interface> class Object : public Interface {
public:
    Object(const char *kind, Remote remote) : kind_(kind), remote_(remote)
    {
    }

    static void *operator new(size_t size) noexcept
    {
        return new_object(size);
    }

    static void operator delete(void *object)
    {
        retire_object(object);
    }

    HRESULT QueryInterface(REFIID iid, PVOID *into) override
    {
        if (into == nullptr)
            return VCI_E_INVALIDARG;
        *into = nullptr;
        if (gone())
            return VCI_E_INVHANDLE;
        if (iid != IID_IUnknown && !is(iid))
            return other(iid, into);
        AddRef();
        *into = static_cast<Interface *>(this);
        return VCI_OK;
    }

    ULONG AddRef() override
    {
        return gone() ? 0 : __atomic_add_fetch(&references_, 1, __ATOMIC_RELAXED);
    }

    ULONG Release() override
    {
        ULONG left;

        if (gone())
            return 0;
        left = __atomic_sub_fetch(&references_, 1, __ATOMIC_ACQ_REL);
        if (left == 0) {
            close();
            Call("", "release", remote_).ask();
            retire_object(this); // its memory stays as it is for now: references_ is 0
        }
        return left;
    }

protected:
    virtual bool is(REFIID iid) const = 0;

    virtual HRESULT other(REFIID, PVOID *)
    {
        return VCI_E_NOINTERFACE;
    }

    virtual void close()
    {
    }

    bool gone() const
    {
        return __atomic_load_n(&references_, __ATOMIC_ACQUIRE) == 0;
    }

    // A call of this object; refused by itself once that was released.
    template <class... Values> HRESULT call(const char *method, const Values &...values)
    {
        Call call(kind_, method, remote_);

        (call.with(values), ...);
        return gone() ? VCI_E_INVHANDLE : call.ask();
    }

    // A call that fills a structure.
    template <class Structure, class... Values>
    HRESULT fill(const char *method, Structure *into, const Values &...values)
    {
        Call call(kind_, method, remote_);

        if (gone())
            return VCI_E_INVHANDLE;
        if (into == nullptr)
            return VCI_E_INVALIDARG;
        (call.with(values), ...);
        return call.ask(into, sizeof *into);
    }

    // A call that gives a number.
    template <class Number, class... Values>
    HRESULT number(const char *method, Number *into, const Values &...values)
    {
        Call call(kind_, method, remote_);
        HRESULT result;

        if (gone())
            return VCI_E_INVHANDLE;
        (call.with(values), ...);
        result = call.ask();
        if (result == VCI_OK && into != nullptr)
            *into = static_cast<Number>(call.value());
        return result;
    }

    // A call that opens another object.
    template <class Class, class Pointer, class... Values>
    HRESULT open(const char *method, const char *kind, Pointer **into, const Values &...values)
    {
        Call call(kind_, method, remote_);
        HRESULT result;

        if (into == nullptr)
            return VCI_E_INVALIDARG;
        *into = nullptr;
        if (gone())
            return VCI_E_INVHANDLE;
        (call.with(values), ...);
        result = call.ask();
        return result == VCI_OK ? made<Class>(kind, call.made(), into) : result;
    }

    template <class Class, class Pointer> static HRESULT made(const char *kind, Remote remote, Pointer **into)
    {
        Class *object = new Class(kind, remote);

        if (object == nullptr) {
            Call("", "release", remote).ask();
            return VCI_E_OUTOFMEMORY;
        }
        *into = object;
        return VCI_OK;
    }

    const char *kind_;
    Remote remote_;

private:
    ULONG references_ = 1;
};
