/* CANDRV's ReadFile with a timeout that is the hub's time, until nothing has come for so long. */
#include <stdio.h>
#include <string.h>

#include <windows.h>
#include "canbusio.h"

int main(void)
{
    COMMTIMEOUTS timeouts = {0, 0, 70, 0, 0};
    CAN_ACCEPTANCE_FILTER all = {0, 0xFFFFFFFF};
    CAN_DWORD rate = 500000, got;
    HANDLE device = CreateFile("CID1:", GENERIC_READ | GENERIC_WRITE, 0, NULL, OPEN_EXISTING, 0, NULL);
    char text[200];
    int answers = 0;

    if (device == INVALID_HANDLE_VALUE || !SetCommTimeouts(device, &timeouts) ||
        !DeviceIoControl(device, IOCTL_CAN_WRITE_ACCEPTANCE_FILTER, &all, sizeof all, NULL, 0, &got, NULL) ||
        !DeviceIoControl(device, IOCTL_CAN_SET_BAUDRATE, &rate, sizeof rate, NULL, 0, &got, NULL))
        return 1;
    while (ReadFile(device, text, sizeof text - 1, &got, NULL)) {
        text[got] = '\0';
        answers += strstr(text, "00000101") != NULL;
    }
    printf("%d until %u, error %u\n", answers, (unsigned)GetTickCount(), (unsigned)GetLastError());
    return CloseHandle(device) ? 0 : 1;
}
