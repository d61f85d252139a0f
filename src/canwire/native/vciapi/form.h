// How elements lie in a FIFO: the records of ../../values/record.py, of which CANMSG and LINMSG are a part.
#pragma once

#include <stdint.h>
#include <vcisdk.h>

enum class Form : uint32_t { PLAIN, CANMSG, CANMSG2, CLASSIC_CANMSG2, LINMSG }; // _FORMS of ../vci/__init__.py

const size_t RECORD = sizeof(CANMSG2);

struct Elements {
    Form form;
    uint32_t record; // bytes in the FIFO

    bool lie_apart() const // an element of the program's is not a record
    {
        return form == Form::CANMSG || form == Form::LINMSG;
    }

    UINT16 size() const
    {
        return static_cast<UINT16>(form == Form::CANMSG ? sizeof(CANMSG) : form == Form::LINMSG ? sizeof(LINMSG) : record);
    }

    // from records into elements side by side
    void load(void *elements, const void *records, uint32_t count) const;
    // and back
    void store(void *records, const void *elements, uint32_t count) const;
    // what a line can never send: VCI_OK, or the code for it
    HRESULT settle(const void *elements, uint32_t count) const;
};
