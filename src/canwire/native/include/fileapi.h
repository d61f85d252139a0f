/* Files and devices by handles: what CANDRV's programs use of them (libcandrv). A name that ends with a colon is a device,
 * as "CID1:"; any other one is a file of Linux'.
 *
 * lpSecurity, dwFlags, hTemplate and lpOverlapped mean nothing, as the manual has it: calls wait as long as
 * SetCommTimeouts says. Source: CANDRV manual V2.06, chapter 8.
 */
#ifndef CANWIRE_FILEAPI_H
#define CANWIRE_FILEAPI_H
#include <windows.h>

#define GENERIC_READ 0x80000000
#define GENERIC_WRITE 0x40000000
#define FILE_SHARE_READ 1
#define FILE_SHARE_WRITE 2
#define CREATE_NEW 1
#define CREATE_ALWAYS 2
#define OPEN_EXISTING 3
#define OPEN_ALWAYS 4
#define TRUNCATE_EXISTING 5
#define FILE_ATTRIBUTE_NORMAL 0x80
#define FILE_FLAG_WRITE_THROUGH 0x80000000
#define FILE_FLAG_OVERLAPPED 0x40000000
#ifndef ERROR_SHARING_VIOLATION
#define ERROR_INVALID_DATA 13
#define ERROR_SHARING_VIOLATION 32
#define ERROR_DEV_NOT_EXIST 55
#define ERROR_FILE_EXISTS 80
#define ERROR_BUSY 170
#define ERROR_BADDB 1009
#define ERROR_IO_DEVICE 1117
#define ERROR_DEVICE_REMOVED 1617
#define ERROR_INVALID_STATE 5023
#endif

typedef struct _COMMTIMEOUTS { /* milliseconds; 0: do not wait, INFINITE: for ever */
    DWORD ReadIntervalTimeout;
    DWORD ReadTotalTimeoutMultiplier;
    DWORD ReadTotalTimeoutConstant;
    DWORD WriteTotalTimeoutMultiplier;
    DWORD WriteTotalTimeoutConstant;
} COMMTIMEOUTS, *LPCOMMTIMEOUTS;

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

HANDLE CreateFileA(LPCSTR lpFileName, DWORD dwAccess, DWORD dwShareMode, LPSECURITY_ATTRIBUTES lpSecurity,
                   DWORD dwCreation, DWORD dwFlags, HANDLE hTemplate);
HANDLE CreateFileW(LPCWSTR lpFileName, DWORD dwAccess, DWORD dwShareMode, LPSECURITY_ATTRIBUTES lpSecurity,
                   DWORD dwCreation, DWORD dwFlags, HANDLE hTemplate);
BOOL ReadFile(HANDLE hDevice, LPVOID lpBuffer, DWORD dwCount, LPDWORD lpdwRead, LPOVERLAPPED lpOverlapped);
BOOL WriteFile(HANDLE hDevice, LPCVOID lpBuffer, DWORD dwCount, LPDWORD lpdwWritten, LPOVERLAPPED lpOverlapped);
int DeviceIoControl(HANDLE hDevice, DWORD dwIoControlCode, LPVOID lpInBuffer, DWORD nInBufferSize, LPVOID lpOutBuffer,
                    DWORD nOutBufferSize, LPDWORD lpReturned, LPOVERLAPPED lpOverlapped);
BOOL SetCommTimeouts(HANDLE hDevice, LPCOMMTIMEOUTS lpTimeouts);
BOOL GetCommTimeouts(HANDLE hDevice, LPCOMMTIMEOUTS lpTimeouts);
BOOL SetCommMask(HANDLE hDevice, DWORD dwEventMask);
BOOL GetCommMask(HANDLE hDevice, LPDWORD lpdwEventMask);
BOOL WaitCommEvent(HANDLE hDevice, LPDWORD lpdwEvent, LPOVERLAPPED lpOverlapped);
/* C's files on devices, too: fprintf, fgets; NULL and GetLastError as CreateFile */
FILE *canwire_fopenA(LPCSTR name, LPCSTR mode);
FILE *canwire_fopenW(LPCWSTR name, LPCWSTR mode);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#ifdef UNICODE
#define CreateFile CreateFileW
#define _wfopen canwire_fopenW
#else
#define CreateFile CreateFileA
#define _wfopen canwire_fopenA /* Windows CE's programs give it their TCHAR */
#endif
#define _tfopen _wfopen
#endif
