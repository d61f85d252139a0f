#include "can.h"
#include "lin.h"

template <class Class, class Interface> static HRESULT made(const char *kind, Remote remote, PVOID *into)
{
    Class *object = new Class(kind, remote);

    if (object == nullptr)
        return VCI_E_OUTOFMEMORY;
    *into = static_cast<Interface *>(object);
    return VCI_OK;
}

static HRESULT made_can(REFIID iid, Remote remote, PVOID *into)
{
    if (iid == IID_ICanSocket)
        return made<CanSocket, ICanSocket>("CanSocket", remote, into);
    if (iid == IID_ICanSocket2)
        return made<CanSocket2, ICanSocket2>("CanSocket2", remote, into);
    if (iid == IID_ICanControl)
        return made<CanControl, ICanControl>("CanControl", remote, into);
    if (iid == IID_ICanControl2)
        return made<CanControl2, ICanControl2>("CanControl2", remote, into);
    if (iid == IID_ICanScheduler)
        return made<CanScheduler, ICanScheduler>("CanScheduler", remote, into);
    if (iid == IID_ICanScheduler2)
        return made<CanScheduler2, ICanScheduler2>("CanScheduler2", remote, into);
    return VCI_E_NOINTERFACE;
}

HRESULT made_socket(REFIID iid, Remote remote, PVOID *into)
{
    HRESULT result;

    if (iid == IID_ILinSocket)
        result = made<LinSocket, ILinSocket>("LinSocket", remote, into);
    else if (iid == IID_ILinControl)
        result = made<LinControl, ILinControl>("LinControl", remote, into);
    else
        result = made_can(iid, remote, into);
    if (result != VCI_OK)
        Call("", "release", remote).ask();
    return result;
}
