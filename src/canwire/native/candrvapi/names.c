/* Names in wide characters. */
#include "candrv.h"

static size_t encoded(char *into, uint32_t letter)
{
    if (letter < 0x80) {
        into[0] = (char)letter;
        return 1;
    }
    if (letter < 0x800) {
        into[0] = (char)(0xC0 | letter >> 6);
        into[1] = (char)(0x80 | (letter & 0x3F));
        return 2;
    }
    if (letter < 0x10000) {
        into[0] = (char)(0xE0 | letter >> 12);
        into[1] = (char)(0x80 | (letter >> 6 & 0x3F));
        into[2] = (char)(0x80 | (letter & 0x3F));
        return 3;
    }
    into[0] = (char)(0xF0 | letter >> 18);
    into[1] = (char)(0x80 | (letter >> 12 & 0x3F));
    into[2] = (char)(0x80 | (letter >> 6 & 0x3F));
    into[3] = (char)(0x80 | (letter & 0x3F));
    return 4;
}

int names_narrow(char *into, size_t room, LPCWSTR name)
{
    size_t length = 0;

    for (; *name != 0; name++) {
        if (length + 5 > room || (uint32_t)*name > 0x10FFFF)
            return -1;
        length += encoded(into + length, (uint32_t)*name);
    }
    into[length] = '\0';
    return 0;
}
