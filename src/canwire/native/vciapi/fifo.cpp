#include "fifo.h"

static const uint32_t COPIES = 1024; // elements that AcquireRead and AcquireWrite hand out at once where they are copied

bool Fifo::is(REFIID iid) const
{
    return iid == IID_IVciFifo || iid == IID_IVciFifo2;
}

HRESULT Fifo::other(REFIID iid, PVOID *into)
{
    Call call(kind_, "query_interface", remote_);

    return open_fifo(call.with(iid), iid, into);
}

HRESULT Fifo::count(const char *method, PUINT16 into)
{
    UINT32 count = 0;
    HRESULT result = into != nullptr ? number(method, &count) : VCI_E_INVALIDARG;

    if (result == VCI_OK)
        *into = static_cast<UINT16>(count < 0xFFFF ? count : 0xFFFF);
    return result;
}

HRESULT Fifo::GetCapacity(PUINT16 into)
{
    return count("get_capacity", into);
}

HRESULT Fifo::GetEntrySize(PUINT16 into)
{
    return count("get_entry_size", into);
}

HRESULT Fifo::GetFreeCount(PUINT16 into)
{
    return count("get_free_count", into);
}

HRESULT Fifo::GetFillCount(PUINT16 into)
{
    return count("get_fill_count", into);
}

HRESULT Fifo::GetFillLevel(PUINT16 into)
{
    return count("get_fill_level", into);
}

HRESULT Fifo::Reset()
{
    return call("reset");
}

template <class Interface> End<Interface>::End(const char *kind, Remote remote) : Object<Interface>(kind, remote)
{
    pthread_mutexattr_t how;

    memset(&ring_, 0, sizeof ring_);
    pthread_mutexattr_init(&how);
    pthread_mutexattr_settype(&how, PTHREAD_MUTEX_RECURSIVE);
    pthread_mutex_init(&lock_, &how);
    pthread_mutexattr_destroy(&how);
}

template <class Interface> HRESULT End<Interface>::map(Call &call, const unsigned char *place, size_t size)
{
    struct cw_place where;
    uint32_t form;

    if (size < sizeof where + sizeof form)
        return VCI_E_UNEXPECTED;
    memcpy(&where, place, sizeof where);
    memcpy(&form, place + sizeof where, sizeof form);
    elements_ = {static_cast<Form>(form), where.record_size};
    return cw_ring_open(&ring_, &where, call.answer()) == 0 ? VCI_OK : VCI_E_OUTOFMEMORY;
}

template <class Interface> void End<Interface>::close()
{
    Using alone(this->use());

    cw_ring_close(&ring_);
    free(copies_);
    copies_ = nullptr;
}

template <class Interface> HRESULT End<Interface>::other(REFIID iid, PVOID *into)
{
    Call call(this->kind_, "query_interface", this->remote_);

    return open_fifo(call.with(iid), iid, into);
}

template <class Interface> pthread_mutex_t *End<Interface>::use()
{
    return this->remote_.process == cw_process() ? &use_ : nullptr;
}

template <class Interface> HRESULT End<Interface>::check()
{
    HRESULT result;

    if (this->gone())
        return VCI_E_INVHANDLE;
    if (!cw_ring_over(&ring_))
        return VCI_OK;
    result = this->call("check");
    return result != VCI_OK ? result : VCI_E_INVHANDLE;
}

template <class Interface> HRESULT End<Interface>::Lock()
{
    HRESULT result;

    {
        Using alone(this->use());
        result = check();
    }
    return result != VCI_OK ? result : pthread_mutex_lock(&lock_) == 0 ? VCI_OK : VCI_E_INVALID_STATE;
}

template <class Interface> HRESULT End<Interface>::Unlock()
{
    return pthread_mutex_unlock(&lock_) == 0 ? VCI_OK : VCI_E_INVALID_STATE;
}

template <class Interface> HRESULT End<Interface>::AssignEvent(HANDLE event)
{
    Using alone(this->use());
    HRESULT result = check();
    struct cw_event *found = nullptr;

    if (result != VCI_OK)
        return result;
    if (event != nullptr && (found = cw_event_of(event)) == nullptr)
        return VCI_E_INVHANDLE;
    if (cw_event_assign(found, &ring_) < 0)
        result = VCI_E_OUTOFMEMORY;
    if (found != nullptr)
        cw_event_release(found);
    return result;
}

template <class Interface> HRESULT End<Interface>::SetThreshold(UINT16 threshold)
{
    Using alone(this->use());
    HRESULT result = check();

    if (result == VCI_OK)
        cw_ring_set_threshold(&ring_, threshold);
    return result;
}

template <class Interface> HRESULT End<Interface>::clamped(PUINT16 into, uint32_t count)
{
    if (into == nullptr)
        return VCI_E_INVALIDARG;
    *into = static_cast<UINT16>(count < 0xFFFF ? count : 0xFFFF);
    return VCI_OK;
}

template <class Interface> HRESULT End<Interface>::GetThreshold(PUINT16 into)
{
    Using alone(this->use());
    HRESULT result = check();

    return result == VCI_OK ? clamped(into, static_cast<uint32_t>(ring_.threshold)) : result;
}

template <class Interface> HRESULT End<Interface>::GetCapacity(PUINT16 into)
{
    Using alone(this->use());
    HRESULT result = check();

    return result == VCI_OK ? clamped(into, ring_.capacity) : result;
}

template <class Interface> HRESULT End<Interface>::GetEntrySize(PUINT16 into)
{
    Using alone(this->use());
    HRESULT result = check();

    return result == VCI_OK ? clamped(into, elements_.size()) : result;
}

template <class Interface> HRESULT End<Interface>::GetFillCount(PUINT16 into)
{
    Using alone(this->use());
    HRESULT result = check();

    return result == VCI_OK ? clamped(into, cw_ring_fill(&ring_)) : result;
}

template <class Interface> HRESULT End<Interface>::GetFreeCount(PUINT16 into)
{
    Using alone(this->use());
    HRESULT result = check();

    return result == VCI_OK ? clamped(into, cw_ring_free(&ring_)) : result;
}

template <class Interface> bool End<Interface>::room_for_copies()
{
    if (copies_ == nullptr) {
        copies_room_ = ring_.capacity < COPIES ? ring_.capacity : COPIES;
        copies_ = static_cast<unsigned char *>(calloc(copies_room_, elements_.size()));
    }
    return copies_ != nullptr;
}

// Without a place for the count one element alone was asked for.
template <class Interface>
HRESULT End<Interface>::hand_out(const void *cells, uint32_t count, PVOID *into, PUINT16 how_many)
{
    acquired_ = how_many == nullptr ? 1 : count < 0xFFFF ? count : 0xFFFF;
    if (how_many != nullptr)
        *how_many = static_cast<UINT16>(acquired_);
    *into = const_cast<void *>(cells);
    return VCI_OK;
}

template class End<IFifoReader>;
template class End<IFifoWriter>;

template <class Class> static HRESULT made_end(Call &call, const char *kind, const unsigned char *place, PVOID *into)
{
    Class *end = new Class(kind, call.made());
    HRESULT result = end != nullptr ? end->map(call, place, call.length()) : VCI_E_OUTOFMEMORY;

    if (result == VCI_OK)
        *into = end;
    else if (end != nullptr)
        end->Release();
    return result;
}

HRESULT open_fifo(Call &call, REFIID iid, PVOID *into, void *behind, size_t size)
{
    unsigned char place[128];
    HRESULT result = call.ask(place, sizeof place);

    *into = nullptr;
    if (result != VCI_OK)
        return result;
    if (iid == IID_IFifoReader)
        result = made_end<Reader>(call, "FifoReader", place, into);
    else if (iid == IID_IFifoWriter)
        result = made_end<Writer>(call, "FifoWriter", place, into);
    else if (Fifo *fifo = new Fifo("VciFifo2", call.made()))
        *into = static_cast<IVciFifo2 *>(fifo);
    else
        result = VCI_E_OUTOFMEMORY;
    if (size > 0 && call.length() >= size && call.length() <= sizeof place)
        memcpy(behind, place + call.length() - size, size);
    return result;
}
