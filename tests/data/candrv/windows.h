/* What the listings of CanWrite and CanRead need of Windows CE, on the C library. TCHAR is char.
 *
 * The device has no controller: what is written to it goes into the file CAN_OUT; what ReadFile gives are the events in
 * the file CAN_IN, each ended by a zero byte, and after the last one Ctrl-C is pressed. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <errno.h>

typedef char TCHAR;
typedef int BOOL;
typedef unsigned int DWORD;
typedef long HANDLE;
typedef struct {
    DWORD ReadIntervalTimeout, ReadTotalTimeoutMultiplier, ReadTotalTimeoutConstant;
    DWORD WriteTotalTimeoutMultiplier, WriteTotalTimeoutConstant;
} COMMTIMEOUTS;

#define FALSE 0
#define TRUE 1
#define INFINITE 0xFFFFFFFF
#define INVALID_HANDLE_VALUE (-1L)
#define GENERIC_READ 0x80000000
#define GENERIC_WRITE 0x40000000
#define CREATE_ALWAYS 2
#define OPEN_EXISTING 3
#define FILE_FLAG_WRITE_THROUGH 0x80000000
#define VK_CONTROL 0x11
#define ERROR_FILE_NOT_FOUND 2
#define ERROR_PATH_NOT_FOUND 3
#define ERROR_ACCESS_DENIED 5

#define _T(text) text
#define _tmain main
#define _tprintf printf
#define _tcstoul strtoul
#define _wfopen stub_open

static DWORD stub_error, stub_rate = 1000000;
static FILE *stub_files[2];

static int stub_is_device(const char *name) { return !strcmp(name, "CID1:") || !strcmp(name, "CID2:"); }

static DWORD GetLastError(void) { return stub_error; }

static FILE *stub_open(const char *name, const char *mode)
{
    FILE *file = fopen(stub_is_device(name) ? getenv("CAN_OUT") : name, mode[0] == 'w' ? "w" : mode);
    if (!file)
        stub_error = errno == ENOENT || errno == ENOTDIR ? ERROR_PATH_NOT_FOUND : ERROR_ACCESS_DENIED;
    return file;
}

static HANDLE CreateFile(const char *name, DWORD access, DWORD share, void *security, DWORD creation, DWORD flags,
                         void *template)
{
    int file = !stub_is_device(name) && creation == CREATE_ALWAYS;
    if (!file && !stub_is_device(name)) {
        stub_error = ERROR_FILE_NOT_FOUND;
        return INVALID_HANDLE_VALUE;
    }
    stub_files[file] = file ? stub_open(name, "w") : fopen(getenv("CAN_IN"), "r");
    return stub_files[file] ? file : INVALID_HANDLE_VALUE;
}

static BOOL CloseHandle(HANDLE handle) { return !fclose(stub_files[handle]); }

static BOOL DeviceIoControl(HANDLE device, DWORD code, void *in, DWORD in_size, void *out, DWORD out_size,
                            DWORD *returned, void *overlapped)
{
    if (in_size == sizeof(DWORD))
        stub_rate = *(DWORD *)in;
    if (out_size == sizeof(DWORD))
        *(DWORD *)out = stub_rate;
    return TRUE;
}

static BOOL SetCommTimeouts(HANDLE device, COMMTIMEOUTS *timeouts) { return TRUE; }

static int GetAsyncKeyState(int key)
{
    int next = getc(stub_files[0]);
    return next == EOF || ungetc(next, stub_files[0]) == EOF;
}

static BOOL ReadFile(HANDLE device, char *buffer, DWORD size, DWORD *count, void *overlapped)
{
    for (*count = 0; *count < size; ++*count)
        if (!(buffer[*count] = getc(stub_files[0])))
            return TRUE;
    return FALSE;
}

static BOOL WriteFile(HANDLE file, const char *buffer, DWORD size, DWORD *written, void *overlapped)
{
    *written = fwrite(buffer, 1, size, stub_files[file]);
    return *written == size;
}
