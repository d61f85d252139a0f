// LUIDs and GUIDs as text, and back: canwire/vci/text.py's forms.
#include "object.h"

#include <ctype.h>

static const size_t LUID_DIGITS = 16, GUID_TEXT = 38;

// into narrow or wide characters; the room counts the final NUL
template <class Character> static HRESULT put(const char *text, Character *into, UINT32 room)
{
    size_t length = strlen(text);

    if (into == nullptr)
        return VCI_E_INVALIDARG;
    if (room <= length)
        return VCI_E_BUFFER_OVERFLOW;
    for (size_t k = 0; k <= length; k++)
        into[k] = static_cast<Character>(text[k]);
    return VCI_OK;
}

template <class Character> static HRESULT put_luid(REFVCIID id, Character *into, UINT32 room)
{
    char text[LUID_DIGITS + 1];

    snprintf(text, sizeof text, "%016llX", static_cast<unsigned long long>(id.AsInt64));
    return put(text, into, room);
}

template <class Character> static HRESULT put_guid(REFGUID guid, Character *into, UINT32 room)
{
    char text[GUID_TEXT + 1];
    const UINT8 *rest = guid.Data4;

    snprintf(text, sizeof text, "{%08X-%04X-%04X-%02X%02X-%02X%02X%02X%02X%02X%02X}", static_cast<unsigned>(guid.Data1), guid.Data2,
             guid.Data3,
             rest[0], rest[1], rest[2], rest[3], rest[4], rest[5], rest[6], rest[7]);
    return put(text, into, room);
}

// The narrow form of a text of exactly this length; false for any other.
template <class Character> static bool narrow(const Character *text, char *into, size_t length)
{
    for (size_t k = 0; k < length; k++) {
        if (text[k] == 0 || static_cast<unsigned long>(text[k]) > 0x7F)
            return false;
        into[k] = static_cast<char>(text[k]);
    }
    into[length] = '\0';
    return text[length] == 0;
}

// `digits` hex digits from `at` on, which moves behind them
static bool number(const char *&at, int digits, unsigned long long &into)
{
    for (into = 0; digits > 0; digits--, at++) {
        if (!isxdigit(static_cast<unsigned char>(*at)))
            return false;
        into = into << 4 | static_cast<unsigned>(*at <= '9' ? *at - '0' : (*at | 0x20) - 'a' + 10);
    }
    return true;
}

template <class Character> static HRESULT get_luid(const Character *text, PVCIID into)
{
    char digits[LUID_DIGITS + 1];
    const char *at = digits;
    unsigned long long found;

    if (text == nullptr || into == nullptr)
        return VCI_E_INVALIDARG;
    if (!narrow(text, digits, LUID_DIGITS) || !number(at, LUID_DIGITS, found))
        return VCI_E_FAIL;
    into->AsInt64 = static_cast<INT64>(found);
    return VCI_OK;
}

template <class Character> static HRESULT get_guid(const Character *text, PGUID into)
{
    char form[GUID_TEXT + 1];
    const char *at = form;
    unsigned long long parts[11];
    GUID made;

    if (text == nullptr || into == nullptr)
        return VCI_E_INVALIDARG;
    if (!narrow(text, form, GUID_TEXT) || *at++ != '{' || form[GUID_TEXT - 1] != '}')
        return VCI_E_FAIL;
    for (int k = 0; k < 11; k++)
        if (!number(at, k == 0 ? 8 : k < 3 ? 4 : 2, parts[k]) || ((k < 3 || k == 4) && *at++ != '-'))
            return VCI_E_FAIL;
    made.Data1 = static_cast<UINT32>(parts[0]);
    made.Data2 = static_cast<UINT16>(parts[1]);
    made.Data3 = static_cast<UINT16>(parts[2]);
    for (int k = 0; k < 8; k++)
        made.Data4[k] = static_cast<UINT8>(parts[3 + k]);
    *into = made;
    return VCI_OK;
}

template <class Character> static HRESULT put_error(HRESULT code, Character *into, UINT32 room)
{
    char text[VCI_MAX_ERRSTRLEN];
    Call call("", "format_error");

    if (into == nullptr || room == 0)
        return VCI_E_INVALIDARG;
    if (call.with(code).ask(text, sizeof text - 1) == VCI_OK)
        text[call.length() < sizeof text ? call.length() : sizeof text - 1] = '\0';
    else // nobody is there to tell what it means
        snprintf(text, sizeof text, "0x%08X", static_cast<unsigned>(code));
    if (strlen(text) >= room)
        text[room - 1] = '\0';
    return put(text, into, room);
}

HRESULT VciFormatErrorA(HRESULT code, PCHAR into, UINT32 room)
{
    return put_error(code, into, room);
}

HRESULT VciFormatErrorW(HRESULT code, PWCHAR into, UINT32 room)
{
    return put_error(code, into, room);
}

HRESULT VciLuidToCharA(REFVCIID id, PCHAR into, UINT32 room)
{
    return put_luid(id, into, room);
}

HRESULT VciLuidToCharW(REFVCIID id, PWCHAR into, UINT32 room)
{
    return put_luid(id, into, room);
}

HRESULT VciCharToLuidA(PCHAR text, PVCIID into)
{
    return get_luid(text, into);
}

HRESULT VciCharToLuidW(PWCHAR text, PVCIID into)
{
    return get_luid(text, into);
}

HRESULT VciGuidToCharA(REFGUID guid, PCHAR into, UINT32 room)
{
    return put_guid(guid, into, room);
}

HRESULT VciGuidToCharW(REFGUID guid, PWCHAR into, UINT32 room)
{
    return put_guid(guid, into, room);
}

HRESULT VciCharToGuidA(PCHAR text, PGUID into)
{
    return get_guid(text, into);
}

HRESULT VciCharToGuidW(PWCHAR text, PGUID into)
{
    return get_guid(text, into);
}
