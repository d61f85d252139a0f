/* CANDRV's calls, by the examples of the manual's chapter 8: hCAN is CID1:, hPeer the board beside it. */
#include <windows.h>
#include "canbusio.h"
#include "checks.h"

static HANDLE hPeer;

static HANDLE Open(LPCTSTR name, DWORD access)
{
    HANDLE made = CreateFile(name, access, FILE_SHARE_READ | FILE_SHARE_WRITE, NULL, OPEN_EXISTING,
                             FILE_FLAG_WRITE_THROUGH, 0);
    CAN_ACCEPTANCE_FILTER all = {0, 0xFFFFFFFF};

    CHECK(made != INVALID_HANDLE_VALUE);
    if (access & GENERIC_READ)
        CHECK(DeviceIoControl(made, IOCTL_CAN_WRITE_ACCEPTANCE_FILTER, &all, sizeof all, NULL, 0, NULL, NULL));
    return made;
}

static CAN_EVENT Next(HANDLE hCAN)
{
    CAN_EVENT cEvent;
    DWORD dwCount;

    CHECK(DeviceIoControl(hCAN, IOCTL_CAN_READ_EVENT_DATA, NULL, 0, &cEvent, sizeof(CAN_EVENT), &dwCount, NULL));
    CHECK(dwCount == sizeof(CAN_EVENT));
    return cEvent;
}

/* 8.3, example 2; its missing semicolon is there */
static void SendCanMessage(HANDLE hCAN, DWORD dwID,
  BOOL bRTR, BYTE chData1, BYTE chData2)
{
 BYTE str[80];
 DWORD dwWritten;

 sprintf(str, "%x %x %x %x %x %x\n", dwID,
  bRTR ? 1 : 0, 2, chData1, chData2);
 WriteFile(hCAN, str, strlen(str),
  &dwWritten, NULL);
}

static void texts(void)
{
    HANDLE hCAN = Open(TEXT("CID1:"), GENERIC_READ | GENERIC_WRITE);
    BYTE str[] = "731 0 4 11 22 33 44\n";
    char text[100], small[10];
    DWORD dwWritten, dwRead;

    CHECK(WriteFile(hCAN, str, strlen(str), &dwWritten,
          NULL));
    CHECK(dwWritten == strlen(str));
    CHECK(Next(hPeer).data.identifier == 0x731);
    SendCanMessage(hCAN, 0x112, FALSE, 0x55, 0xAA);
    CHECK(Next(hPeer).data.msg[1] == 0xAA);
    SendCanMessage(hPeer, 0x7, FALSE, 1, 2);
    CHECK(SetCommMask(hCAN, CANBUS_EVENT_RECEIVED));
    CHECK(ReadFile(hCAN, text, sizeof text, &dwRead, NULL));
    CHECK(dwRead == strlen(text) && strncmp(text, "received\t0:", 11) == 0);
    CHECK(strstr(text, "\t00000007\t0\t2\r\n\t01\t02\t") != NULL);
    SendCanMessage(hPeer, 0x8, FALSE, 1, 2);
    FAILS(ERROR_INSUFFICIENT_BUFFER, ReadFile(hCAN, small, sizeof small, &dwRead, NULL));
    CHECK(dwRead == 0 && Next(hCAN).data.identifier == 8);
    FAILS(ERROR_INVALID_PARAMETER, WriteFile(hCAN, "1 0 1 fff\n", 10, &dwWritten, NULL));
    FAILS(ERROR_INVALID_PARAMETER, WriteFile(hCAN, NULL, 2, &dwWritten, NULL));
    FAILS(ERROR_INVALID_PARAMETER, ReadFile(hCAN, NULL, 100, &dwRead, NULL));
    CHECK(CloseHandle(hCAN));
}

static void timeouts_and_masks(void)
{
    HANDLE hCAN = Open(TEXT("CID1:"), GENERIC_READ);
    COMMTIMEOUTS cTimeouts;
    DWORD dwEventMask, dwEvent, dwRead;
    char text[100];

    CHECK(GetCommTimeouts(hCAN, &cTimeouts));
    cTimeouts.ReadTotalTimeoutConstant = 30;
    CHECK(SetCommTimeouts(hCAN, &cTimeouts));
    cTimeouts.ReadTotalTimeoutConstant = 0;
    CHECK(GetCommTimeouts(hCAN, &cTimeouts) && cTimeouts.ReadTotalTimeoutConstant == 30);
    CHECK(GetCommMask(hCAN, &dwEventMask) && dwEventMask & CANBUS_EVENT_DEVICE_CHANGED);
    dwEventMask &= ~CANBUS_EVENT_DEVICE_CHANGED;
    CHECK(SetCommMask(hCAN, dwEventMask));
    CHECK(GetCommMask(hCAN, &dwEventMask) && !(dwEventMask & CANBUS_EVENT_DEVICE_CHANGED));
    FAILS(ERROR_TIMEOUT, ReadFile(hCAN, text, sizeof text, &dwRead, NULL));
    SendCanMessage(hPeer, 0x9, FALSE, 1, 2);
    CHECK(WaitCommEvent(hCAN, &dwEvent, NULL) && dwEvent == CANBUS_EVENT_RECEIVED);
    CHECK(Next(hCAN).data.identifier == 9);
    FAILS(ERROR_INVALID_PARAMETER, SetCommTimeouts(hCAN, NULL));
    FAILS(ERROR_INVALID_PARAMETER, GetCommTimeouts(hCAN, NULL));
    CHECK(CloseHandle(hCAN));
}

static void structures(void)
{
    HANDLE hCAN = Open(TEXT("CID1:"), GENERIC_READ | GENERIC_WRITE);
    CAN_ACCEPTANCE_FILTER cFilter = {0x120, 0x007};
    CAN_TRANSMIT_DATA cData;
    CAN_TIME time;
    DWORD dwCount, dwMode = CANBUS_FORMAT_CAN_2_0_B;
    BYTE chCmd = CANBUS_CMD_CLEAR_OVERRUN;

    CHECK(DeviceIoControl(hCAN, IOCTL_CAN_SET_CAN_MODE, &dwMode, sizeof dwMode, NULL, 0, NULL, NULL));
    CHECK(DeviceIoControl(hCAN, IOCTL_CAN_WRITE_ACCEPTANCE_FILTER,
 &cFilter, sizeof(CAN_ACCEPTANCE_FILTER),
 NULL, 0, NULL, NULL));
    cFilter.code = 0;
    CHECK(DeviceIoControl(hCAN,
 IOCTL_CAN_READ_ACCEPTANCE_FILTER, NULL, 0,
 &cFilter, sizeof(CAN_ACCEPTANCE_FILTER),
 &dwCount, NULL));
    CHECK(cFilter.code == 0x120 && cFilter.mask == 7 && dwCount == sizeof cFilter);
    cData.fmt = CANBUS_TRANS_FMT_STD;
    cData.identifier = 0x123;
    cData.rtr = 0;
    cData.dlc = 2;
    cData.msg[0] = 0x11;
    cData.msg[1] = 0x22;
    CHECK(DeviceIoControl(hCAN,
 IOCTL_CAN_WRITE_TRANSMIT_DATA,
 &cData, sizeof(CAN_TRANSMIT_DATA),
 NULL, 0, NULL, NULL));
    CHECK(Next(hPeer).data.identifier == 0x123);
    FAILS(ERROR_INVALID_PARAMETER,
          DeviceIoControl(hCAN, IOCTL_CAN_WRITE_TRANSMIT_DATA, &cData, 4, NULL, 0, NULL, NULL));
    FAILS(ERROR_INVALID_PARAMETER,
          DeviceIoControl(hCAN, IOCTL_CAN_WRITE_TRANSMIT_DATA, NULL, sizeof cData, NULL, 0, NULL, NULL));
    CHECK(DeviceIoControl(hCAN, IOCTL_CAN_READ_TIME, NULL, 0, &time, sizeof time, &dwCount, NULL));
    CHECK(DeviceIoControl(hCAN, IOCTL_CAN_SET_COMMAND, &chCmd, sizeof(chCmd), NULL, 0, NULL, NULL));
    CHECK(CloseHandle(hCAN));
}

static void the_device(void)
{
    HANDLE hCAN = Open(TEXT("CID1:"), 0);
    CAN_PROPERTIES properties;
    DWORD dwBaudrate = 0, dwCount, status;
    BYTE address[2] = {0, 0}, value = 0xEE;

    CHECK(DeviceIoControl(hCAN, IOCTL_CAN_GET_BAUDRATE, NULL, 0, &dwBaudrate, sizeof dwBaudrate, NULL, NULL));
    CHECK(dwBaudrate == 1000000);
    CHECK(DeviceIoControl(hCAN, IOCTL_CAN_SET_BAUDRATE, &dwBaudrate, sizeof dwBaudrate, NULL, 0, NULL, NULL));
    memset(&properties, 0xEE, sizeof properties);
    CHECK(DeviceIoControl(hCAN, IOCTL_CAN_READ_PROPERTIES, NULL, 0, &properties, sizeof properties, &dwCount, NULL));
    CHECK(dwCount == sizeof properties && properties.version >> 8 == 2 && properties.device_name[99] == 0);
    CHECK(properties.max == 1000000 && properties.nCommands == 9 && properties.nRegisters > 0);
    CHECK(properties.commands[0] == CANBUS_CMD_ENTER_STANDBY);
    memset(&properties, 0xEE, sizeof properties);
    FAILS(ERROR_INSUFFICIENT_BUFFER, DeviceIoControl(hCAN, IOCTL_CAN_READ_PROPERTIES, NULL, 0, &properties, 100, NULL, NULL));
    CHECK(properties.version == 0xEEEEEEEE);
    CHECK(DeviceIoControl(hCAN, IOCTL_CAN_READ_REGISTER, address, 1, &value, sizeof value, NULL, NULL));
    SetLastError(0);
    CHECK(DeviceIoControl(hCAN, IOCTL_CAN_TEST_DEVICE, NULL, 0, NULL, 0, NULL, NULL) == 0);
    CHECK(GetLastError() == 0);
    CHECK(DeviceIoControl(hCAN, IOCTL_CAN_INIT, NULL, 0, &status, sizeof status, NULL, NULL));
    FAILS(ERROR_NOT_SUPPORTED, DeviceIoControl(hCAN, 0x1234, NULL, 0, NULL, 0, NULL, NULL));
    FAILS(ERROR_ACCESS_DENIED, WriteFile(hCAN, "1 0 0\n", 6, &dwCount, NULL));
    CHECK(CloseHandle(hCAN));
    FAILS(ERROR_INVALID_HANDLE, DeviceIoControl(hCAN, IOCTL_CAN_TEST_DEVICE, NULL, 0, NULL, 0, NULL, NULL));
}

static void wrong_handles(void)
{
    HANDLE none[] = {NULL, INVALID_HANDLE_VALUE, (HANDLE)6, (HANDLE)0x4000, (HANDLE)0x123456789, CreateEvent(NULL, FALSE, FALSE, NULL)};
    COMMTIMEOUTS timeouts;
    DWORD count;
    char text[100];

    for (size_t k = 0; k < ARRAYSIZE(none); k++) {
        FAILS(ERROR_INVALID_HANDLE, ReadFile(none[k], text, sizeof text, &count, NULL));
        FAILS(ERROR_INVALID_HANDLE, WriteFile(none[k], text, 1, &count, NULL));
        FAILS(ERROR_INVALID_HANDLE, GetCommTimeouts(none[k], &timeouts));
        FAILS(ERROR_INVALID_HANDLE, GetCommMask(none[k], &count));
        FAILS(ERROR_INVALID_HANDLE, WaitCommEvent(none[k], &count, NULL));
    }
    CHECK(CloseHandle(none[5]));
    FAILS(ERROR_INVALID_HANDLE, CloseHandle(none[5]));
    FAILS(ERROR_FILE_NOT_FOUND, CreateFile(TEXT("CID9:"), 0, 0, NULL, OPEN_EXISTING, 0, NULL) != INVALID_HANDLE_VALUE);
    FAILS(ERROR_FILE_EXISTS, CreateFile(TEXT("CID1:"), 0, 0, NULL, CREATE_NEW, 0, NULL) != INVALID_HANDLE_VALUE);
    FAILS(ERROR_INVALID_PARAMETER, CreateFile(NULL, 0, 0, NULL, OPEN_EXISTING, 0, NULL) != INVALID_HANDLE_VALUE);
    FAILS(ERROR_FILE_NOT_FOUND, CreateFile("/none/at/all", 0, 0, NULL, OPEN_EXISTING, 0, NULL) != INVALID_HANDLE_VALUE);
    FAILS(ERROR_FILE_NOT_FOUND, CreateFileW(L"CID9:", 0, 0, NULL, OPEN_EXISTING, 0, NULL) != INVALID_HANDLE_VALUE);
}

static DWORD CALLBACK read_one(LPVOID handle)
{
    char text[100];
    DWORD count;

    return ReadFile(handle, text, sizeof text, &count, NULL) ? 0 : GetLastError();
}

/* Whoever waits is let go by CloseHandle, as the manual's 7.8 says. */
static void closing_ends_waiting(void)
{
    HANDLE hCAN = Open(TEXT("CID1:"), GENERIC_READ), thread;
    COMMTIMEOUTS cTimeouts = {0, 0, INFINITE, 0, INFINITE};
    DWORD dwEventMask = CANBUS_EVENT_ABORTED, code = 0;

    CHECK(SetCommTimeouts(hCAN, &cTimeouts) && SetCommMask(hCAN, dwEventMask));
    thread = CreateThread(NULL, 0, read_one, hCAN, 0, NULL);
    CHECK(WaitForSingleObject(thread, 50) == WAIT_TIMEOUT);
    CHECK(CloseHandle(hCAN));
    CHECK(WaitForSingleObject(thread, INFINITE) == WAIT_OBJECT_0 && GetExitCodeThread(thread, &code));
    CHECK(code == ERROR_OPERATION_ABORTED || code == ERROR_INVALID_HANDLE);
    CHECK(CloseHandle(thread));
}

int main(void)
{
    hPeer = Open(TEXT("CID2:"), GENERIC_READ | GENERIC_WRITE);
    CHECK(SetCommMask(hPeer, CANBUS_EVENT_RECEIVED));
    texts();
    timeouts_and_masks();
    structures();
    the_device();
    wrong_handles();
    closing_ends_waiting();
    CHECK(CloseHandle(hPeer));
    puts("CANDRV did what it says");
    return 0;
}
