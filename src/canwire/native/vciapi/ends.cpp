// Reading and writing: no call to anybody, and no system call while the other side is awake.
#include "fifo.h"

bool Reader::is(REFIID iid) const
{
    return iid == IID_IFifoReader;
}

HRESULT Reader::GetDataEntry(PVOID into)
{
    Using alone(this->use());
    HRESULT result = check();
    uint32_t count = 0;
    const void *cells = result == VCI_OK ? cw_ring_acquire(&ring_, &count) : nullptr;

    if (cells == nullptr)
        return result != VCI_OK ? result : VCI_E_RXQUEUE_EMPTY;
    acquired_ = 0;
    if (into != nullptr) // else it is thrown away
        elements_.load(into, cells, 1);
    cw_ring_release(&ring_, 1);
    cw_ring_touched(&ring_);
    return VCI_OK;
}

HRESULT Reader::AcquireRead(PVOID *into, PUINT16 count)
{
    Using alone(this->use());
    HRESULT result = check();
    uint32_t there = 0;
    const void *cells;

    if (result != VCI_OK)
        return result;
    if (into == nullptr)
        return VCI_E_INVALIDARG;
    acquired_ = 0;
    *into = nullptr;
    cells = cw_ring_acquire(&ring_, &there);
    if (cells == nullptr) {
        if (count != nullptr)
            *count = 0;
        return VCI_E_RXQUEUE_EMPTY;
    }
    if (elements_.lie_apart()) {
        if (!room_for_copies())
            return VCI_E_OUTOFMEMORY;
        there = count == nullptr ? 1 : there < copies_room_ ? there : copies_room_;
        elements_.load(copies_, cells, there);
        cells = copies_;
    }
    return hand_out(cells, there, into, count);
}

HRESULT Reader::ReleaseRead(UINT16 count)
{
    Using alone(this->use());
    HRESULT result = check();

    if (result == VCI_OK && count > acquired_)
        result = VCI_E_INVALIDARG;
    if (result != VCI_OK)
        return result;
    acquired_ = 0;
    if (count > 0)
        cw_ring_release(&ring_, count);
    cw_ring_touched(&ring_);
    return VCI_OK;
}

bool Writer::is(REFIID iid) const
{
    return iid == IID_IFifoWriter;
}

HRESULT Writer::PutDataEntry(PVOID data)
{
    Using alone(this->use());
    HRESULT result = check();
    uint32_t count;
    void *cells;

    if (result == VCI_OK)
        result = data != nullptr ? elements_.settle(data, 1) : VCI_E_INVALIDARG;
    if (result != VCI_OK)
        return result;
    acquired_ = 0;
    cells = cw_ring_acquire_free(&ring_, &count);
    if (cells == nullptr)
        return VCI_E_TXQUEUE_FULL;
    elements_.store(cells, data, 1);
    cw_ring_commit(&ring_, 1);
    cw_ring_touched(&ring_);
    return VCI_OK;
}

HRESULT Writer::AcquireWrite(PVOID *into, PUINT16 count)
{
    Using alone(this->use());
    HRESULT result = check();
    uint32_t there = 0;

    if (result != VCI_OK)
        return result;
    if (into == nullptr)
        return VCI_E_INVALIDARG;
    acquired_ = 0;
    *into = nullptr;
    cells_ = cw_ring_acquire_free(&ring_, &there);
    if (cells_ == nullptr) {
        if (count != nullptr)
            *count = 0;
        return VCI_E_TXQUEUE_FULL;
    }
    if (!elements_.lie_apart())
        return hand_out(cells_, there, into, count);
    if (!room_for_copies())
        return VCI_E_OUTOFMEMORY;
    return hand_out(copies_, there < copies_room_ ? there : copies_room_, into, count);
}

HRESULT Writer::ReleaseWrite(UINT16 count)
{
    Using alone(this->use());
    HRESULT result = check();
    const void *elements = elements_.lie_apart() ? copies_ : cells_;

    if (result == VCI_OK && count > acquired_)
        result = VCI_E_INVALIDARG;
    if (result == VCI_OK && count > 0)
        result = elements_.settle(elements, count);
    if (result != VCI_OK)
        return result;
    acquired_ = 0;
    if (count > 0) {
        if (elements_.lie_apart())
            elements_.store(cells_, copies_, count);
        cw_ring_commit(&ring_, count);
    }
    cw_ring_touched(&ring_);
    return VCI_OK;
}
