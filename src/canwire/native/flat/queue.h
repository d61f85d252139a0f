// One end of a channel's or monitor's FIFO, with an event: reading and writing that wait.
#pragma once

#include "handles.h"

template <class End> struct Queue {
    End *end;
    HANDLE event;
    int ending; // its handle is being closed: nobody waits any more

    HRESULT open(UINT16 threshold)
    {
        HRESULT result = VCI_OK;

        event = CreateEventA(nullptr, FALSE, FALSE, nullptr);
        if (event == nullptr)
            result = VCI_E_OUTOFMEMORY;
        if (result == VCI_OK)
            result = end->SetThreshold(threshold);
        return result == VCI_OK ? end->AssignEvent(event) : result;
    }

    void close()
    {
        if (end != nullptr)
            end->AssignEvent(nullptr);
        release(end);
        if (event != nullptr)
            CloseHandle(event);
        event = nullptr;
    }

    // Whoever waits has to go, with VCI_E_INVHANDLE; `close` comes when the last of them has gone.
    void end_waits()
    {
        __atomic_store_n(&ending, 1, __ATOMIC_SEQ_CST);
        if (event != nullptr)
            SetEvent(event);
    }

    // Until `met()` says something else than `empty`; VCI_E_TIMEOUT.
    template <class Met> HRESULT wait(UINT32 timeout_ms, HRESULT empty, Met met)
    {
        Deadline deadline(timeout_ms);
        HRESULT result;

        while ((result = met()) == empty) {
            if (__atomic_load_n(&ending, __ATOMIC_SEQ_CST)) {
                SetEvent(event); // it wakes one thread at a time
                return VCI_E_INVHANDLE;
            }
            if (WaitForSingleObject(event, deadline.left()) != WAIT_OBJECT_0)
                return (result = met()) == empty ? VCI_E_TIMEOUT : result;
        }
        return result;
    }
};

template <class Message> struct Reading : Queue<IFifoReader> {
    // Messages that are there, without waiting; VCI_E_RXQUEUE_EMPTY for none.
    HRESULT peek(Message *into, UINT32 count, PUINT32 done)
    {
        UINT32 got = 0;
        HRESULT result = end->Lock();

        if (result != VCI_OK)
            return result;
        while (got < count && (result = end->GetDataEntry(into + got)) == VCI_OK)
            got++;
        end->Unlock();
        if (done != nullptr)
            *done = got;
        return got > 0 || count == 0 ? VCI_OK : result;
    }

    // The same, waiting for the first one.
    HRESULT read(UINT32 timeout_ms, Message *into, UINT32 count, PUINT32 done)
    {
        return wait(timeout_ms, VCI_E_RXQUEUE_EMPTY, [&] { return peek(into, count, done); });
    }

    HRESULT wait_for_some(UINT32 timeout_ms)
    {
        return wait(timeout_ms, VCI_E_RXQUEUE_EMPTY, [&] {
            UINT16 count = 0, threshold = 1;
            HRESULT result = end->GetFillCount(&count);

            end->GetThreshold(&threshold);
            return result != VCI_OK ? result : count >= threshold ? VCI_OK : VCI_E_RXQUEUE_EMPTY;
        });
    }
};

template <class Message> struct Writing : Queue<IFifoWriter> {
    // As many messages as fit, without waiting; VCI_E_TXQUEUE_FULL for none.
    HRESULT post(Message *messages, UINT32 count, PUINT32 done)
    {
        UINT32 put = 0;
        HRESULT result = end->Lock();

        if (result != VCI_OK)
            return result;
        while (put < count && (result = end->PutDataEntry(messages + put)) == VCI_OK)
            put++;
        end->Unlock();
        if (done != nullptr)
            *done = put;
        return put > 0 || count == 0 ? VCI_OK : result;
    }

    // All of them, waiting for room; `done` says how many went where there was not room in time.
    HRESULT send(UINT32 timeout_ms, Message *messages, UINT32 count, PUINT32 done)
    {
        UINT32 put = 0;
        HRESULT result = wait(timeout_ms, VCI_E_TXQUEUE_FULL, [&] {
            UINT32 now = 0;
            HRESULT posted = post(messages + put, count - put, &now);

            put += now;
            return posted == VCI_OK && put < count ? VCI_E_TXQUEUE_FULL : posted;
        });

        if (done != nullptr)
            *done = put;
        return result;
    }

    HRESULT wait_for_room(UINT32 timeout_ms)
    {
        return wait(timeout_ms, VCI_E_TXQUEUE_FULL, [&] {
            UINT16 count = 0, threshold = 1;
            HRESULT result = end->GetFreeCount(&count);

            end->GetThreshold(&threshold);
            return result != VCI_OK ? result : count >= threshold ? VCI_OK : VCI_E_TXQUEUE_FULL;
        });
    }
};
