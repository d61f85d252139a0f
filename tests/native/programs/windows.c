/* Windows' functions by themselves: events, waits, threads, mutexes, semaphores, libraries. No hub, no helper. */
#include <process.h>

#include "vci.h"

static HANDLE automatic, manual;

static unsigned waiter(void *unused)
{
    (void)unused;
    return WaitForSingleObject(automatic, INFINITE) == WAIT_OBJECT_0 ? 42 : 1;
}

static void events(void)
{
    HANDLE both[2];

    automatic = CreateEvent(NULL, FALSE, TRUE, NULL);
    manual = CreateEvent(NULL, TRUE, FALSE, NULL);
    both[0] = automatic;
    both[1] = manual;
    TRUE_THAT(WaitForSingleObject(automatic, 0) == WAIT_OBJECT_0); /* and takes it */
    TRUE_THAT(WaitForSingleObject(automatic, 1) == WAIT_TIMEOUT);
    TRUE_THAT(SetEvent(manual) && WaitForMultipleObjects(2, both, FALSE, INFINITE) == WAIT_OBJECT_0 + 1);
    TRUE_THAT(WaitForMultipleObjects(2, both, TRUE, 1) == WAIT_TIMEOUT);
    TRUE_THAT(SetEvent(automatic) && WaitForMultipleObjects(2, both, TRUE, INFINITE) == WAIT_OBJECT_0);
    TRUE_THAT(WaitForSingleObject(automatic, 0) == WAIT_TIMEOUT);
    TRUE_THAT(WaitForSingleObject(manual, 0) == WAIT_OBJECT_0 && ResetEvent(manual));
    TRUE_THAT(WaitForSingleObject(manual, 0) == WAIT_TIMEOUT);
}

static void refused(void)
{
    TRUE_THAT(!SetEvent(NULL) && GetLastError() == ERROR_INVALID_HANDLE);
    TRUE_THAT(!SetEvent(INVALID_HANDLE_VALUE) && !CloseHandle((HANDLE)0x5555));
    TRUE_THAT(WaitForSingleObject((HANDLE)12, 0) == WAIT_FAILED && GetLastError() == ERROR_INVALID_HANDLE);
    TRUE_THAT(WaitForMultipleObjects(0, NULL, FALSE, 0) == WAIT_FAILED && GetLastError() == ERROR_INVALID_PARAMETER);
    TRUE_THAT(!ReleaseMutex(manual) && !ReleaseSemaphore(manual, 1, NULL));
}

static void counted(void)
{
    HANDLE semaphore = CreateSemaphore(NULL, 1, 2, NULL), mutex = CreateMutex(NULL, TRUE, NULL);
    LONG before;

    TRUE_THAT(WaitForSingleObject(semaphore, 0) == WAIT_OBJECT_0 && WaitForSingleObject(semaphore, 0) == WAIT_TIMEOUT);
    TRUE_THAT(ReleaseSemaphore(semaphore, 2, &before) && before == 0 && !ReleaseSemaphore(semaphore, 1, NULL));
    TRUE_THAT(WaitForSingleObject(mutex, 0) == WAIT_OBJECT_0); /* a second time, by its owner */
    TRUE_THAT(ReleaseMutex(mutex) && ReleaseMutex(mutex) && !ReleaseMutex(mutex));
    TRUE_THAT(CloseHandle(semaphore) && CloseHandle(mutex));
}

int main(void)
{
    HANDLE thread;
    HMODULE library;
    DWORD code;

    events();
    refused();
    counted();
    thread = (HANDLE)_beginthreadex(NULL, 0, waiter, NULL, 0, NULL);
    TRUE_THAT(GetExitCodeThread(thread, &code));
    TRUE_THAT(SetEvent(automatic) && WaitForSingleObject(thread, INFINITE) == WAIT_OBJECT_0);
    TRUE_THAT(GetExitCodeThread(thread, &code) && code == 42 && CloseHandle(thread));
    library = LoadLibrary("C:\\Windows\\VCINPL2.DLL");
    TRUE_THAT(library != NULL && GetProcAddress(library, "canChannelOpen") != NULL);
    TRUE_THAT(GetProcAddress(library, "nothing") == NULL && GetLastError() == ERROR_PROC_NOT_FOUND);
    TRUE_THAT(FreeLibrary(library) && LoadLibrary("none.dll") == NULL && GetLastError() == ERROR_MOD_NOT_FOUND);
    puts("Windows' functions");
    return 0;
}
