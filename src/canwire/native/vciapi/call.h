// A call of canwire.vci through the helper: arguments packed one after the other, as ../vci/arguments.py takes them.
#pragma once

#include "canwire.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vcisdk.h>

// What of an object the helper knows: its number, and which process opened it.
struct Remote {
    uint32_t number;
    uint32_t process;
};

class Call {
public:
    Call(const char *kind, const char *method, Remote object = {0, cw_process()});
    ~Call();
    Call(const Call &) = delete;

    template <class Value> Call &with(const Value &value)
    {
        return bytes(&value, sizeof value);
    }

    Call &bytes(const void *data, size_t size);

    // VCI_OK with the answer's data in `out`, or canwire.vci's code; VCI_E_DISCONNECTED when nobody answers.
    HRESULT ask(void *out = nullptr, size_t size = 0);

    uint32_t value() const
    {
        return call_.value;
    }

    size_t length() const
    {
        return call_.out_length;
    }

    struct cw_call *answer()
    {
        return &call_;
    }

    Remote made() const
    {
        return {call_.value, object_.process};
    }

private:
    char name_[CW_METHOD_SIZE];
    unsigned char in_[2304]; // DetectBaud's table is the largest
    struct cw_call call_;
    Remote object_;
};
