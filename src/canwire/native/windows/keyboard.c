/* Keys, one by one: the terminal hands them over without waiting for a line while somebody looks. */
#include "conio.h"
#include "windows_core.h"

#include <poll.h>
#include <termios.h>
#include <unistd.h>

static int raw(struct termios *before)
{
    struct termios now;

    if (tcgetattr(0, before) < 0)
        return 0;
    now = *before;
    now.c_lflag &= ~(tcflag_t)(ICANON | ECHO);
    return tcsetattr(0, TCSANOW, &now) == 0;
}

int _kbhit(void)
{
    struct termios before;
    struct pollfd keys = {0, POLLIN, 0};
    int changed = raw(&before), found = poll(&keys, 1, 0) > 0;

    if (changed)
        tcsetattr(0, TCSANOW, &before);
    return found;
}

int _getch(void)
{
    struct termios before;
    unsigned char key;
    int changed, got;

    fflush(stdout);
    changed = raw(&before);
    got = (int)read(0, &key, 1);
    if (changed)
        tcsetattr(0, TCSANOW, &before);
    return got == 1 ? key : -1;
}

int _getche(void)
{
    int key = _getch();

    return key < 0 ? key : putchar(key);
}

int _putch(int character)
{
    return putchar(character);
}
