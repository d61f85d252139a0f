/* What programs written for VCI, CANDRV or ACAN use of Windows, for Linux. No more than that: canwire is no Wine.
 *
 * Text is char; programs that define UNICODE get wchar_t. LONG and DWORD have 32 bits as on Windows, pointers the
 * machine's. Names of events and mutexes are taken and mean nothing: there is no object that two processes share.
 */
#ifndef CANWIRE_WINDOWS_H
#define CANWIRE_WINDOWS_H
#ifndef _WINDOWS_
#define _WINDOWS_
#endif

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <wchar.h>

#define WINAPI
#define APIENTRY
#define CALLBACK
#define WINAPIV
#define PASCAL
#define __stdcall
#define _stdcall
#define __cdecl
#define _cdecl
#define __fastcall
#define __declspec(what)
#define CONST const
#define VOID void
#define IN
#define OUT
#define OPTIONAL
#define FAR
#define __int8 char
#define __int16 short
#define __int32 int
#define __int64 long long
#ifndef _MAX_PATH
#define _MAX_PATH 260
#define MAX_PATH 260
#endif

typedef char CHAR, *PCHAR, *LPSTR, *PSTR;
typedef const char *LPCSTR, *PCSTR, *PCCH;
typedef wchar_t WCHAR, *PWCHAR, *LPWSTR, *PWSTR;
typedef const wchar_t *LPCWSTR, *PCWSTR;
typedef unsigned char UCHAR, *PUCHAR, BYTE, *PBYTE, *LPBYTE, BOOLEAN, *PBOOLEAN;
typedef int8_t INT8, *PINT8;
typedef uint8_t UINT8, *PUINT8;
typedef int16_t INT16, *PINT16, SHORT, *PSHORT;
typedef uint16_t UINT16, *PUINT16, USHORT, *PUSHORT, WORD, *PWORD, *LPWORD;
typedef int32_t INT32, *PINT32, LONG, *PLONG, *LPLONG, LONG32, *PLONG32, INT, *PINT, *LPINT, BOOL, *PBOOL, *LPBOOL;
typedef uint32_t UINT32, *PUINT32, ULONG, *PULONG, ULONG32, UINT, *PUINT, DWORD, *PDWORD, *LPDWORD, DWORD32;
#ifdef __cplusplus
typedef long long INT64, *PINT64, LONGLONG, *PLONGLONG, LONG64, __time64_t;
typedef unsigned long long UINT64, *PUINT64, ULONGLONG, *PULONGLONG, DWORDLONG, DWORD64, ULONG64;
#else
typedef long long INT64, *PINT64, LONGLONG, *PLONGLONG, LONG64;
typedef unsigned long long UINT64, *PUINT64, ULONGLONG, *PULONGLONG, DWORDLONG, DWORD64, ULONG64;
#endif
typedef intptr_t INT_PTR, LONG_PTR, *PLONG_PTR, SSIZE_T;
typedef uintptr_t UINT_PTR, ULONG_PTR, *PULONG_PTR, DWORD_PTR, *PDWORD_PTR, SIZE_T, WPARAM;
typedef intptr_t LPARAM, LRESULT;
typedef float FLOAT;
typedef void *PVOID, *LPVOID, *HANDLE, *HWND, *HINSTANCE, *HMODULE, *HICON, *HKEY;
typedef const void *LPCVOID;
typedef HANDLE *PHANDLE, *LPHANDLE;
typedef LONG HRESULT, SCODE, NTSTATUS;
typedef LONG_PTR (*FARPROC)(void);
#ifdef UNICODE
typedef WCHAR TCHAR, *PTCHAR;
typedef LPWSTR LPTSTR, PTSTR;
typedef LPCWSTR LPCTSTR;
#define TEXT(quoted) L##quoted
#else
typedef char TCHAR, *PTCHAR;
typedef LPSTR LPTSTR, PTSTR;
typedef LPCSTR LPCTSTR;
#define TEXT(quoted) quoted
#endif

#ifndef TRUE
#define TRUE 1
#define FALSE 0
#endif
#define INFINITE 0xFFFFFFFF
#define INVALID_HANDLE_VALUE ((HANDLE)(LONG_PTR)-1)
#define WAIT_OBJECT_0 0
#define WAIT_ABANDONED_0 0x80
#define WAIT_ABANDONED 0x80
#define WAIT_IO_COMPLETION 0xC0
#define WAIT_TIMEOUT 258
#define WAIT_FAILED 0xFFFFFFFF
#define MAXIMUM_WAIT_OBJECTS 64
#define STILL_ACTIVE 259

#define ERROR_SUCCESS 0
#define NO_ERROR 0
#define ERROR_FILE_NOT_FOUND 2
#define ERROR_ACCESS_DENIED 5
#define ERROR_INVALID_HANDLE 6
#define ERROR_NOT_ENOUGH_MEMORY 8
#define ERROR_NOT_READY 21
#define ERROR_GEN_FAILURE 31
#define ERROR_NOT_SUPPORTED 50
#define ERROR_INVALID_PARAMETER 87
#define ERROR_INSUFFICIENT_BUFFER 122
#define ERROR_MOD_NOT_FOUND 126
#define ERROR_PROC_NOT_FOUND 127
#define ERROR_NOT_OWNER 288
#define ERROR_OPERATION_ABORTED 995
#define ERROR_IO_INCOMPLETE 996
#define ERROR_IO_PENDING 997
#define ERROR_NO_SYSTEM_RESOURCES 1450
#define ERROR_TIMEOUT 1460
#define S_OK ((HRESULT)0)
#define S_FALSE ((HRESULT)1)
#define NOERROR 0
#define E_UNEXPECTED ((HRESULT)0x8000FFFF)
#define E_NOTIMPL ((HRESULT)0x80004001)
#define E_NOINTERFACE ((HRESULT)0x80004002)
#define E_POINTER ((HRESULT)0x80004003)
#define E_FAIL ((HRESULT)0x80004005)
#define E_INVALIDARG ((HRESULT)0x80070057)
#define E_OUTOFMEMORY ((HRESULT)0x8007000E)
#define SUCCEEDED(result) ((HRESULT)(result) >= 0)
#define FAILED(result) ((HRESULT)(result) < 0)

#define LOBYTE(word) ((BYTE)((DWORD_PTR)(word) & 0xFF))
#define HIBYTE(word) ((BYTE)((DWORD_PTR)(word) >> 8 & 0xFF))
#define LOWORD(dword) ((WORD)((DWORD_PTR)(dword) & 0xFFFF))
#define HIWORD(dword) ((WORD)((DWORD_PTR)(dword) >> 16 & 0xFFFF))
#define MAKEWORD(low, high) ((WORD)((BYTE)(low) | (WORD)(BYTE)(high) << 8))
#define MAKELONG(low, high) ((LONG)((WORD)(low) | (DWORD)(WORD)(high) << 16))
#define ZeroMemory(at, size) memset((at), 0, (size))
#define FillMemory(at, size, byte) memset((at), (byte), (size))
#define CopyMemory(into, from, size) memcpy((into), (from), (size))
#define MoveMemory(into, from, size) memmove((into), (from), (size))
#define UNREFERENCED_PARAMETER(name) (void)(name)
#define ARRAYSIZE(array) (sizeof(array) / sizeof((array)[0]))
#define _countof(array) ARRAYSIZE(array)
#define _stricmp strcasecmp
#define _strnicmp strncasecmp
#define stricmp strcasecmp
#define _snprintf snprintf
#define lstrlenA strlen
#define lstrcpyA strcpy

typedef struct _SECURITY_ATTRIBUTES {
    DWORD nLength;
    LPVOID lpSecurityDescriptor;
    BOOL bInheritHandle;
} SECURITY_ATTRIBUTES, *PSECURITY_ATTRIBUTES, *LPSECURITY_ATTRIBUTES;

typedef struct _LUID {
    DWORD LowPart;
    LONG HighPart;
} LUID, *PLUID;

typedef union _LARGE_INTEGER {
    struct {
        DWORD LowPart;
        LONG HighPart;
    };
    struct {
        DWORD LowPart;
        LONG HighPart;
    } u;
    LONGLONG QuadPart;
} LARGE_INTEGER, *PLARGE_INTEGER;

typedef struct _OVERLAPPED {
    ULONG_PTR Internal;
    ULONG_PTR InternalHigh;
    union {
        struct {
            DWORD Offset;
            DWORD OffsetHigh;
        };
        PVOID Pointer;
    };
    HANDLE hEvent;
} OVERLAPPED, *LPOVERLAPPED;

typedef struct _FILETIME {
    DWORD dwLowDateTime;
    DWORD dwHighDateTime;
} FILETIME, *LPFILETIME;

typedef struct _SYSTEMTIME {
    WORD wYear, wMonth, wDayOfWeek, wDay, wHour, wMinute, wSecond, wMilliseconds;
} SYSTEMTIME, *LPSYSTEMTIME;

typedef struct _CRITICAL_SECTION {
    union {
        LONGLONG aligned;
        char room[64];
    };
} CRITICAL_SECTION, *PCRITICAL_SECTION, *LPCRITICAL_SECTION;

typedef DWORD(WINAPI *LPTHREAD_START_ROUTINE)(LPVOID);
typedef LPTHREAD_START_ROUTINE PTHREAD_START_ROUTINE;

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

DWORD GetLastError(void);
void SetLastError(DWORD code);
BOOL CloseHandle(HANDLE object);
HANDLE CreateEventA(LPSECURITY_ATTRIBUTES rights, BOOL manual_reset, BOOL signalled, LPCSTR name);
HANDLE CreateEventW(LPSECURITY_ATTRIBUTES rights, BOOL manual_reset, BOOL signalled, LPCWSTR name);
BOOL SetEvent(HANDLE event);
BOOL ResetEvent(HANDLE event);
BOOL PulseEvent(HANDLE event);
DWORD WaitForSingleObject(HANDLE object, DWORD milliseconds);
DWORD WaitForSingleObjectEx(HANDLE object, DWORD milliseconds, BOOL alertable);
DWORD WaitForMultipleObjects(DWORD count, const HANDLE *objects, BOOL all, DWORD milliseconds);
DWORD WaitForMultipleObjectsEx(DWORD count, const HANDLE *objects, BOOL all, DWORD milliseconds, BOOL alertable);
HANDLE CreateMutexA(LPSECURITY_ATTRIBUTES rights, BOOL owned, LPCSTR name);
HANDLE CreateMutexW(LPSECURITY_ATTRIBUTES rights, BOOL owned, LPCWSTR name);
BOOL ReleaseMutex(HANDLE mutex);
HANDLE CreateSemaphoreA(LPSECURITY_ATTRIBUTES rights, LONG first, LONG most, LPCSTR name);
BOOL ReleaseSemaphore(HANDLE semaphore, LONG count, LPLONG before);
HANDLE CreateThread(LPSECURITY_ATTRIBUTES rights, SIZE_T stack, LPTHREAD_START_ROUTINE start, LPVOID argument,
                    DWORD flags, LPDWORD number);
void ExitThread(DWORD code);
BOOL GetExitCodeThread(HANDLE thread, LPDWORD code);
BOOL SetThreadPriority(HANDLE thread, int priority);
DWORD GetCurrentThreadId(void);
DWORD GetCurrentProcessId(void);
HANDLE GetCurrentThread(void);
HANDLE GetCurrentProcess(void);
BOOL SetPriorityClass(HANDLE process, DWORD priority);
void InitializeCriticalSection(LPCRITICAL_SECTION section);
void EnterCriticalSection(LPCRITICAL_SECTION section);
BOOL TryEnterCriticalSection(LPCRITICAL_SECTION section);
void LeaveCriticalSection(LPCRITICAL_SECTION section);
void DeleteCriticalSection(LPCRITICAL_SECTION section);
void Sleep(DWORD milliseconds);
DWORD SleepEx(DWORD milliseconds, BOOL alertable);
DWORD GetTickCount(void);
ULONGLONG GetTickCount64(void);
DWORD timeGetTime(void);
BOOL QueryPerformanceCounter(PLARGE_INTEGER count);
BOOL QueryPerformanceFrequency(PLARGE_INTEGER hertz);
void GetLocalTime(LPSYSTEMTIME time);
void GetSystemTime(LPSYSTEMTIME time);
/* "vciapi.dll" and its siblings are canwire's; any other name is dlopen's */
HMODULE LoadLibraryA(LPCSTR name);
HMODULE LoadLibraryW(LPCWSTR name);
FARPROC GetProcAddress(HMODULE library, LPCSTR name);
BOOL FreeLibrary(HMODULE library);
void OutputDebugStringA(LPCSTR text);
int MessageBoxA(HWND above, LPCSTR text, LPCSTR caption, UINT kind); /* to stderr; IDOK */

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#define VK_RETURN 0x0D
#define VK_ESCAPE 0x1B
#define VK_SPACE 0x20
#define THREAD_PRIORITY_NORMAL 0
#define THREAD_PRIORITY_ABOVE_NORMAL 1
#define THREAD_PRIORITY_HIGHEST 2
#define THREAD_PRIORITY_TIME_CRITICAL 15
#define NORMAL_PRIORITY_CLASS 0x20
#define HIGH_PRIORITY_CLASS 0x80
#define REALTIME_PRIORITY_CLASS 0x100
#define InterlockedIncrement(at) __atomic_add_fetch((at), 1, __ATOMIC_SEQ_CST)
#define InterlockedDecrement(at) __atomic_sub_fetch((at), 1, __ATOMIC_SEQ_CST)
#define InterlockedExchange(at, value) __atomic_exchange_n((at), (value), __ATOMIC_SEQ_CST)
#define InterlockedExchangeAdd(at, value) __atomic_fetch_add((at), (value), __ATOMIC_SEQ_CST)
#ifdef UNICODE
#define CreateEvent CreateEventW
#define CreateMutex CreateMutexW
#define LoadLibrary LoadLibraryW
#else
#define CreateEvent CreateEventA
#define CreateMutex CreateMutexA
#define LoadLibrary LoadLibraryA
#endif
#define CreateSemaphore CreateSemaphoreA
#define OutputDebugString OutputDebugStringA
#define MessageBox MessageBoxA
#define MB_OK 0
#define MB_ICONSTOP 0x10
#define MB_ICONERROR 0x10
#define MB_ICONINFORMATION 0x40
#define IDOK 1

#include <objbase.h>
#endif
