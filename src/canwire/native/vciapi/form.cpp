#include "form.h"

// in a record: time, a reserved word, identifier, information, data; CANMSG lacks the second, LINMSG the third too
static const size_t ID = 8, INFO = 12, CAN_REST = sizeof(CANMSG) - 4, LIN_REST = sizeof(LINMSG) - 4;

void Elements::load(void *elements, const void *records, uint32_t count) const
{
    const char *from = static_cast<const char *>(records);
    char *into = static_cast<char *>(elements);
    size_t at = form == Form::CANMSG ? ID : INFO, rest = form == Form::CANMSG ? CAN_REST : LIN_REST;

    if (!lie_apart()) {
        memcpy(into, from, size_t(count) * record);
        return;
    }
    for (; count > 0; count--, from += record, into += 4 + rest) {
        memcpy(into, from, 4);
        memcpy(into + 4, from + at, rest);
    }
}

void Elements::store(void *records, const void *elements, uint32_t count) const
{
    const char *from = static_cast<const char *>(elements);
    char *into = static_cast<char *>(records);

    if (!lie_apart()) {
        memcpy(into, from, size_t(count) * record);
        return;
    }
    for (; count > 0; count--, from += sizeof(CANMSG), into += record) {
        memset(into, 0, record);
        memcpy(into, from, 4);
        memcpy(into + ID, from + 4, CAN_REST);
    }
}

HRESULT Elements::settle(const void *elements, uint32_t count) const
{
    const char *at = static_cast<const char *>(elements);

    if (form != Form::CANMSG && form != Form::CLASSIC_CANMSG2)
        return VCI_OK;
    for (; count > 0; count--, at += size()) {
        CANMSGINFO info;
        memcpy(&info, at + (form == Form::CANMSG ? offsetof(CANMSG, uMsgInfo) : offsetof(CANMSG2, uMsgInfo)), sizeof info);
        if (info.Bits.edl || info.Bits.fdr)
            return form == Form::CANMSG ? VCI_E_INVALIDARG : VCI_E_NOT_SUPPORTED;
    }
    return VCI_OK;
}
