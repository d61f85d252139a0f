/* The keyboard as CANDRV's samples ask it. Ctrl-C ends a program on Linux, so no key ever is down here. */
#ifndef CANWIRE_WINUSER_H
#define CANWIRE_WINUSER_H
#include <windows.h>
#define VK_CONTROL 0x11
static inline SHORT GetAsyncKeyState(int key)
{
    (void)key;
    return 0;
}
#endif
