// FIFOs and their ends.
#pragma once

#include "form.h"
#include "object.h"

#include <pthread.h>

class Fifo : public Object<IVciFifo2> {
public:
    using Object::Object;
    HRESULT GetCapacity(PUINT16 into) override;
    HRESULT GetEntrySize(PUINT16 into) override;
    HRESULT GetFreeCount(PUINT16 into) override;
    HRESULT GetFillCount(PUINT16 into) override;
    HRESULT GetFillLevel(PUINT16 into) override;
    HRESULT Reset() override;

protected:
    bool is(REFIID iid) const override;
    HRESULT other(REFIID iid, PVOID *into) override;

private:
    HRESULT count(const char *method, PUINT16 into);
};

// A call uses an end alone, so that another thread may release it meanwhile; NULL: there is nothing to be alone with.
class Using {
public:
    explicit Using(pthread_mutex_t *by) : by_(by)
    {
        if (by_ != nullptr)
            pthread_mutex_lock(by_);
    }

    ~Using()
    {
        if (by_ != nullptr)
            pthread_mutex_unlock(by_);
    }

    Using(const Using &) = delete;

private:
    pthread_mutex_t *by_;
};

// One end: its ring, and what of it was handed out.
template <class Interface> class End : public Object<Interface> {
public:
    End(const char *kind, Remote remote);
    HRESULT map(Call &call, const unsigned char *place, size_t size); // takes the descriptors
    HRESULT Lock() override;
    HRESULT Unlock() override;
    HRESULT AssignEvent(HANDLE event) override;
    HRESULT SetThreshold(UINT16 threshold) override;
    HRESULT GetThreshold(PUINT16 into) override;
    HRESULT GetCapacity(PUINT16 into) override;
    HRESULT GetEntrySize(PUINT16 into) override;
    HRESULT GetFillCount(PUINT16 into) override;
    HRESULT GetFreeCount(PUINT16 into) override;

protected:
    HRESULT other(REFIID iid, PVOID *into) override;
    void close() override;
    HRESULT check(); // VCI_OK, or what keeps it from being used
    HRESULT hand_out(const void *cells, uint32_t count, PVOID *into, PUINT16 how_many);
    bool room_for_copies();
    pthread_mutex_t *use(); // NULL in a fork, where a thread of the parent's may have it for ever

    struct cw_ring ring_;
    Elements elements_;
    uint32_t acquired_ = 0;
    unsigned char *copies_ = nullptr; // of elements that do not lie side by side in the ring
    uint32_t copies_room_ = 0;

private:
    HRESULT clamped(PUINT16 into, uint32_t count);

    pthread_mutex_t use_ = PTHREAD_MUTEX_INITIALIZER;
    pthread_mutex_t lock_; // the program's
};

class Reader : public End<IFifoReader> {
public:
    using End::End;
    HRESULT GetDataEntry(PVOID into) override;
    HRESULT AcquireRead(PVOID *into, PUINT16 count) override;
    HRESULT ReleaseRead(UINT16 count) override;

protected:
    bool is(REFIID iid) const override;
};

class Writer : public End<IFifoWriter> {
public:
    using End::End;
    HRESULT PutDataEntry(PVOID data) override;
    HRESULT AcquireWrite(PVOID *into, PUINT16 count) override;
    HRESULT ReleaseWrite(UINT16 count) override;

protected:
    bool is(REFIID iid) const override;

private:
    void *cells_ = nullptr;
};

// The interface of a FIFO that a call asks for; `behind` gets what the answer has after that.
HRESULT open_fifo(Call &call, REFIID iid, PVOID *into, void *behind = nullptr, size_t size = 0);
